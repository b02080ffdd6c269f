//! Results of `solve` per face, as CSV and as PLY.

use std::fmt::Write as _;

use glam::DVec3;

use milkglass::internals::session::run::Session;
use milkglass::internals::session::subdivide::Parts;
use milkglass::scene::Object;

/// One row of results per input face, object after object, in input order: centroid, area, irradiance, radiosity, and
/// an error estimate if there is one.
struct Row {
    object: usize,
    input_face: u32,
    center: DVec3,
    area: f64,
    irradiance: [f64; 3],
    radiosity: [f64; 3],
    estimate: Option<[f64; 3]>,
    /// Indices of the corners among the vertices of all objects.
    triangle: [u32; 3],
}

/// An object's vertices in scene units, deformed if the object is.
fn vertices(session: &Session, object: usize) -> Vec<DVec3> {
    let (mesh, part) = (&session.scene().objects[object].mesh, &session.state().objects[object]);
    if part.deforms == 0 {
        return mesh.positions.clone();
    }
    let own = &session.state().data.positions[part.first.vertices..][..part.count.vertices];
    own.iter().map(|p| session.units().outside(DVec3::from_array(p.map(f64::from)))).collect()
}

fn rows(session: &Session) -> Vec<Row> {
    let (data, units) = (&session.state().data, session.units());
    let light = |value: [f32; 3]| value.map(|x| f64::from(x) * units.light);
    let mut first = 0;
    let of_object = |(object, Object { mesh, .. }): (usize, &Object)| {
        let (before, vertices) = (first, vertices(session, object));
        first += vertices.len() as u32;
        let row = move |(of_mesh, face): (usize, usize)| {
            let triangle = mesh.triangles[of_mesh];
            let [a, b, c] = triangle.map(|v| vertices[v as usize]);
            Row {
                object,
                input_face: mesh.input_face[of_mesh],
                center: (a + b + c) / 3.0,
                area: 0.5 * (b - a).cross(c - a).length(),
                irradiance: light(data.irradiance[face]),
                radiosity: light(data.radiosity[face]),
                estimate: data.estimate.get(face).copied().map(light),
                triangle: triangle.map(|v| v + before),
            }
        };
        let rows = session.prepared().places(object).into_iter().enumerate().map(row).collect::<Vec<_>>();
        match session.parts().get(object) {
            Some(parts) => put_together(rows, parts, before),
            None => rows,
        }
    };
    session.scene().objects.iter().enumerate().flat_map(of_object).collect()
}

/// Combines the rows of a subdivided object's parts into rows of its original triangles: mean irradiance over the
/// triangle, radiosity of the part at its centre.
fn put_together(parts: Vec<Row>, made: &Parts, before: u32) -> Vec<Row> {
    let mut sums = vec![(0.0, DVec3::ZERO, DVec3::ZERO); made.whole.len()];
    for (row, &whole) in parts.iter().zip(&made.of) {
        let (area, center, light) = &mut sums[whole as usize];
        *area += row.area;
        *center += row.area * row.center;
        *light += row.area * DVec3::from_array(row.irradiance);
    }
    let whole = |(face, &middle): (usize, &u32)| {
        let (row, (area, center, light)) = (&parts[middle as usize], sums[face]);
        let mean = |sum: DVec3, else_: DVec3| if area > 0.0 { sum / area } else { else_ };
        Row {
            object: row.object,
            input_face: made.input_face[face],
            center: mean(center, row.center),
            area,
            irradiance: mean(light, DVec3::from_array(row.irradiance)).to_array(),
            radiosity: row.radiosity,
            estimate: row.estimate.map(|own| {
                let missed = made.missed.get(middle as usize).copied().unwrap_or_default();
                [0, 1, 2].map(|c| own[c].hypot(missed[c]))
            }),
            triangle: made.whole[face].map(|v| v + before),
        }
    };
    made.middle.iter().enumerate().map(whole).collect()
}

pub(super) fn csv(session: &Session) -> String {
    let mut text = String::from("face,cx,cy,cz,area,E_r,E_g,E_b,B_r,B_g,B_b,input_face");
    text += if session.state().method.estimate { ",err_r,err_g,err_b" } else { "" };
    let several = session.scene().objects.len() > 1;
    text += if several { ",object\n" } else { "\n" };
    for (face, row) in rows(session).iter().enumerate() {
        let (c, e, b) = (row.center, row.irradiance.map(digits), row.radiosity.map(digits));
        let _ = write!(text, "{face},{:.9e},{:.9e},{:.9e},{:.9e}", c.x, c.y, c.z, row.area);
        let _ = write!(text, ",{},{},{},{},{},{}", e[0], e[1], e[2], b[0], b[1], b[2]);
        let _ = write!(text, ",{}", row.input_face);
        for x in row.estimate.iter().flatten() {
            let _ = write!(text, ",{}", digits(*x));
        }
        if several {
            let _ = write!(text, ",{}", row.object);
        }
        text.push('\n');
    }
    text
}

/// An amount of light with the digits of an `f32`, also outside its range.
fn digits(x: f64) -> String {
    let single = x as f32;
    if single.is_normal() || x == 0.0 { format!("{single:e}") } else { format!("{x:.7e}") }
}

/// An amount of light as a PLY float, clamped to the largest one.
fn single(x: f64) -> f32 {
    x.min(f32::MAX.into()) as f32
}

pub(super) fn ply(session: &Session) -> String {
    let rows = rows(session);
    let positions: Vec<DVec3> =
        (0..session.scene().objects.len()).flat_map(|object| vertices(session, object)).collect();

    // Vertex values are area-weighted means, as in stage `average`; the brightest maps to white.
    let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
    for row in &rows {
        for vertex in row.triangle {
            let (sum, area) = &mut sums[vertex as usize];
            *sum += row.area * DVec3::from_array(row.radiosity);
            *area += row.area;
        }
    }
    let values: Vec<DVec3> = sums.iter().map(|&(sum, area)| if area > 0.0 { sum / area } else { sum }).collect();
    let brightest = values.iter().map(|v| v.max_element()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n\
         element face {}\nproperty list uchar int vertex_indices\n\
         property float E_r\nproperty float E_g\nproperty float E_b\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n{}end_header\n",
        values.len(),
        rows.len(),
        if session.state().method.estimate {
            "property float err_r\nproperty float err_g\nproperty float err_b\n"
        } else {
            ""
        }
    );
    for (p, value) in positions.iter().zip(&values) {
        let byte = |x: f64| (milkglass::internals::view::picture::encode(x / brightest) * 255.0 + 0.5) as u8;
        let b = value.to_array();
        let [red, green, blue] = b.map(byte);
        let _ = writeln!(
            text,
            "{} {} {} {red} {green} {blue} {} {} {}",
            p.x as f32,
            p.y as f32,
            p.z as f32,
            single(b[0]),
            single(b[1]),
            single(b[2])
        );
    }
    for row in &rows {
        let [a, b, c] = row.triangle;
        let _ = write!(text, "3 {a} {b} {c}");
        for x in row.irradiance.iter().chain(&row.radiosity).chain(row.estimate.iter().flatten()) {
            let _ = write!(text, " {}", single(*x));
        }
        text.push('\n');
    }
    text
}
