//! Encodings, lists, texture coordinates, colours and faults.

use super::*;

const HEAD: &str = "comment caf\u{e9}\nelement vertex 5\nproperty float x\nproperty double y\nproperty short z\n\
                    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n\
                    element face 2\nproperty uchar quality\nproperty list ushort int vertex_indices\n\
                    element edge 1\nproperty int a\nend_header\n";
/// x, y, z, red, s of each vertex; green is 255, blue is 0, t is half of s.
const VERTICES: [(f32, f64, i16, u8, f32); 5] = [
    (0.0, 0.0, 0, 0, 0.0),
    (2.0, 0.0, 0, 128, 1.0),
    (2.0, 2.5, 1, 255, 0.5),
    (0.0, 2.5, 1, 51, 0.25),
    (9.0, 9.0, 9, 0, 0.0),
];
const FACES: [&[i32]; 2] = [&[0, 1, 2, 3], &[2, 1, 0]];

fn ascii() -> Vec<u8> {
    let mut text = format!("ply\nformat ascii 1.0\n{HEAD}");
    for (x, y, z, red, s) in VERTICES {
        text += &format!("{x} {y} {z} {red} 255 0 {s} {}\n", s / 2.0);
    }
    for face in FACES {
        text += &format!("7 {} {}\n", face.len(), face.iter().map(i32::to_string).collect::<Vec<_>>().join(" "));
    }
    (text + "3\n").into_bytes()
}

fn binary(big: bool) -> Vec<u8> {
    fn put<const N: usize>(bytes: &mut Vec<u8>, little: [u8; N], big: bool) {
        let mut all = little;
        if big {
            all.reverse();
        }
        bytes.extend(all);
    }
    let order = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEAD}").into_bytes();
    for (x, y, z, red, s) in VERTICES {
        put(&mut bytes, x.to_le_bytes(), big);
        put(&mut bytes, y.to_le_bytes(), big);
        put(&mut bytes, z.to_le_bytes(), big);
        bytes.extend([red, 255, 0]);
        put(&mut bytes, s.to_le_bytes(), big);
        put(&mut bytes, (s / 2.0).to_le_bytes(), big);
    }
    for face in FACES {
        bytes.push(7);
        put(&mut bytes, (face.len() as u16).to_le_bytes(), big);
        face.iter().for_each(|corner| put(&mut bytes, corner.to_le_bytes(), big));
    }
    put(&mut bytes, 3i32.to_le_bytes(), big);
    bytes
}

fn of(bytes: &[u8], own: bool) -> Checked<Soup> {
    read(&Files::default(), bytes, Some(Coordinates { key: "texture", own }), true)
}

#[test]
fn normals_are_those_of_the_vertices() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let rest = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let with = "property float nx\nproperty float ny\nproperty float nz\n";
    let text = format!("{head}{with}{rest}0 0 0 0 0 2\n1 0 0 1 0 0\n0 1 0 0 0 0\n3 2 0 1\n");
    let soup = |text: &str, wanted| read(&Files::default(), text.as_bytes(), None, wanted).expect("a triangle");
    assert_eq!(soup(&text, true).normals, Some(vec![[DVec3::ZERO, 2.0 * DVec3::Z, DVec3::X]]));
    assert_eq!(soup(&text, false).normals, None);
    assert_eq!(soup(&format!("{head}{rest}0 0 0\n1 0 0\n0 1 0\n3 2 0 1\n"), true).normals, None);
}

#[test]
fn every_encoding_gives_the_same_mesh() {
    for bytes in [ascii(), binary(false), binary(true)] {
        let soup = of(&bytes, false).expect("three triangles");
        assert_eq!(soup.triangles, [[0, 1, 2], [0, 2, 3], [2, 1, 0]]);
        assert_eq!((soup.input_face, soup.unused, soup.positions.len()), (vec![0, 0, 1], 1, 4));
        assert_eq!(soup.positions[3], DVec3::new(0.0, 2.5, 1.0));
        assert_eq!(soup.uvs.expect("coordinates")[1], [[0.0, 0.0], [0.5, 0.25], [0.25, 0.125]]);
        assert_eq!(soup.notes.len(), 1);
        assert!(of(&bytes, true).expect("three triangles").notes.is_empty());
        let (size, texels) = texture(&Files::default(), &bytes).expect("colours");
        assert_eq!((size, texels[0], texels[4]), ([4, 4], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]));
        assert!((texels[1][0] - 0.215_860_5).abs() < 1e-6, "sRGB 128 in linear light");
    }
}

#[test]
fn texture_coordinates_may_belong_to_faces() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar uint8 vertex_index\nproperty list uchar float texcoord\n\
                end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0.5 1";
    let uvs = of(text.as_bytes(), false).expect("a triangle").uvs;
    assert_eq!(uvs, Some(vec![[[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]]));
    let fault = texture(&Files::default(), text.as_bytes()).expect_err("no colours").to_string();
    assert!(fault.starts_with("the vertices have no colours; found no properties red"), "{fault}");
}

#[test]
fn faults_say_what_and_where() {
    let file = |head: &str, rest: &str| format!("ply\nformat ascii 1.0\n{head}end_header\n{rest}");
    let vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = |count: &str| format!("{vertices}element face {count}\nproperty list uchar int vertex_index\n");
    let three = "0 0 0\n1 0 0\n0 1 0\n";
    let cases = [
        ("ply\nformat ascii 1.0\n".into(), "Unexpected end of file while reading header"),
        ("ply\nformat ascii\nend_header\n".into(), "Couldn't parse line; found format ascii"),
        ("ply\nformat ascii 1.0\nelement vertex 3\nproperty flat x\n".into(), "found property flat x"),
        (file("element vertex 1\nproperty float x\n", "0\n"), "the vertices have no position; found x; expected"),
        (file("element face 1\nproperty float x\n", "0\n"), "the faces have no corners; found x; expected a list"),
        (file("element vertex 9\n", ""), "the file is shorter than its header states; found 0 bytes after it"),
        (file(vertices, three), "the mesh has no faces; found 0 faces"),
        (file(&faces("1"), &format!("{three}3 0 1 3\n")), "a face names a vertex that is not there; found 3 in face 0"),
        (
            file(&faces("1"), &format!("{three}3 0 1 -1\n")),
            "found a negative number in face 0; expected numbers from 0",
        ),
        (file(&faces("1"), &format!("{three}3 0 1\n")), "not an element `face`; found 3 0 1; expected vertex_index"),
        (file(&faces("4000000000"), three), "the file is shorter than its header states"),
        (
            file(&faces("1"), "0 0 0\n1 0 1e39\n0 1 0\n3 0 1 2\n"),
            "a coordinate is not finite or too large; found [1, 0",
        ),
    ];
    for (text, expected) in cases {
        let fault = read(&Files::default(), text.as_bytes(), None, true).expect_err(expected).to_string();
        assert!(fault.contains(expected), "{fault}");
    }
    let text = file(&faces("1"), "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n");
    assert_eq!(read(&Files::default(), text.as_bytes(), None, true).expect_err("no number").line, Some(11));
}

#[test]
fn numbers_are_written_in_any_way_and_what_is_ignored_cannot_refuse_a_file() {
    let file = |head: &str, vertices: &str, face: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n{head}\
             element face 1\nproperty list uchar int vertex_index\nproperty uchar quality\nend_header\n{vertices}{face}"
        )
    };
    let positions = |text: &str| read(&Files::default(), text.as_bytes(), None, true).map(|soup| soup.positions);
    let expected = || vec![DVec3::new(0.5, -0.5, 5.0), DVec3::new(1.0, 100.0, 0.01), DVec3::ZERO];
    let places = [".5 -.5 5.", "+1 1E+2 1.e-2", "0 -0 +.0"];
    let normals = "property float nx\nproperty list uchar float more\n";
    for ignored in ["nan 0", "-1.#IND 1 nan(ind)", "x 2 inf 1e999", "0x1p3 +1.0 ,"] {
        let vertices: String = places.iter().map(|place| format!("{place} {ignored}\n")).collect();
        assert_eq!(positions(&file(normals, &vertices, "3.0 0 1.0 +2 none\n")).expect(ignored), expected());
    }
    let plain = file("", &(places.join("\n\n  ") + "\n"), "3 0 1 2 0");
    for text in [plain.replace('\n', "\r\n"), plain.replace('\n', "\r"), plain.replace("end_header", "end_header ")] {
        assert_eq!(positions(&text).expect("a triangle"), expected(), "{text:?}");
    }
    for bad in [".", "+", "1.5e", "nan", "0,5", "1 2", ""] {
        let fault = positions(&file("", &format!("0 0 0\n1 0 {bad}\n0 1 0\n"), "3 0 1 2 0")).expect_err(bad);
        assert_eq!(fault.line, Some(12), "{fault}");
    }
    for face in ["2.5 0 1 2 0", "3 0 1 2", "-1 0", "3 0 1 0.5 0"] {
        let fault = positions(&file("", "0 0 0\n1 0 0\n0 1 0\n", face)).expect_err(face);
        assert_eq!(fault.line, Some(14), "{fault}");
    }
}

#[test]
fn concave_polygons_keep_their_area_with_their_coordinates_and_colours() {
    let corners = [[2, 1], [1, 1], [1, 2], [0, 2], [0, 0], [2, 0]];
    for first in 0..6 {
        let mut text =
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                        property float u\nproperty float v\nproperty float red\nproperty float green\n\
                        property float blue\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
                .to_owned();
        for [x, y] in (0..6).map(|k| corners[(first + k) % 6]) {
            text += &format!("{x} {y} 0 {x} {y} {} {} 0\n", f64::from(x) / 2.0, f64::from(y) / 2.0);
        }
        text += "6 0 1 2 3 4 5\n";
        let soup = of(text.as_bytes(), false).expect("four triangles");
        let at = |corner: u32| soup.positions[corner as usize];
        let doubled = soup.triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).z);
        assert_eq!((soup.triangles.len(), doubled.sum::<f64>()), (4, 6.0), "from corner {first}");
        assert_eq!(soup.input_face, [0; 4]);
        let places = soup.triangles.iter().map(|triangle| triangle.map(|corner| [at(corner).x, at(corner).y]));
        assert_eq!(soup.uvs.expect("coordinates"), places.collect::<Vec<_>>());
        let (size, texels) = texture(&Files::default(), text.as_bytes()).expect("colours");
        assert_eq!(size, [4, 4]);
        let first = at(soup.triangles[0][0]);
        assert_eq!(texels[0], [first.x as f32 / 2.0, first.y as f32 / 2.0, 0.0]);
    }
}
