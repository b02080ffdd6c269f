//! The look of pictures: light that leaves, reflections, backgrounds, tone; and what is refused.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

use crate::shell::{bad, bytes, folder, good, read};
use milkglass::internals::lighting::fresnel::{facet_cosine, facet_tilt, transmittance};
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::antialiasing::picture;
use milkglass::internals::session::run::Session;
use milkglass::scene::{Scene, Sky, Source};

/// A session of a small ball with these settings after one frame on the CPU.
fn session(sets: &[&str]) -> Session {
    let small = ["object.0.detail=2", "camera.size=[48, 40]"];
    let sets: Vec<_> = small.iter().chain(sets).map(ToString::to_string).collect();
    let mut session = Session::new(&Scene::load_with("sphere", &sets).unwrap(), None, Options::default());
    session.as_mut().unwrap().frame(Change::EVERYTHING).unwrap();
    session.unwrap()
}

#[test]
fn all_light_leaves_where_the_exit_is_normalised() {
    const ETA: &str = "object.0.material.eta=[0.8, 1.3, 2.0]";
    let (mut paper, mut whole) = (session(&[ETA]), session(&[ETA, "object.0.material.normalize_exit=true"]));
    let exit = whole.state().data.object_params[0].exit.map(f64::from);
    for (eta, exit) in [0.8, 1.3, 2.0].into_iter().zip(exit) {
        // L cos over the hemisphere, for B = 1.
        let steps = 20_000;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
        let sum: f64 = (0..steps).map(|i| 2.0 * PI * at(i) * transmittance(eta, at(i)) * exit / PI).sum();
        assert!((sum / f64::from(steps) - 1.0).abs() < 1e-5, "{eta}: {sum}");
    }
    let shown: Vec<bool> = whole.state().data.hits.iter().map(|hit| hit.face != u32::MAX).collect();
    let (paper, whole) = (paper.picture().unwrap().pixels, whole.picture().unwrap().pixels);
    for ((a, b), _) in paper.iter().zip(&whole).zip(shown).filter(|(_, shown)| *shown) {
        assert!((0..3).all(|c| (f64::from(a[c]) * exit[c] - f64::from(b[c])).abs() <= 1e-6 * f64::from(b[c])));
    }
}

/// The cosine between the interpolated normal and the eye where a pixel shows a face.
fn seen_cosine(session: &Session, pixel: usize) -> Option<f64> {
    let data = &session.state().data;
    let (hit, eye) = (data.hits[pixel], glam::Vec3::from(data.camera[0].origin).as_dvec3());
    let corners = data.triangles.get(hit.face as usize)?;
    let mix = |of: &[[f32; 3]]| -> DVec3 {
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        corners.iter().zip(weights).map(|(&v, weight)| (glam::Vec3::from(of[v as usize]) * weight).as_dvec3()).sum()
    };
    Some(mix(&data.normals).normalize().dot((eye - mix(&data.positions)).normalize()))
}

/// Seen from where no light is reflected to.
#[test]
fn light_leaves_a_rough_surface_through_its_facets() {
    let behind = "light.0={ type = 'directional', direction = [0, 0, -1], irradiance = 30 }";
    let common = [behind, "object.0.detail=3", "camera.position=[0, 0, 30]", "camera.target=[0, 0, 0]"];
    let common = [&common[..], &["object.0.material.normalize_exit=true"]].concat();
    let rough = ["object.0.material.reflection=ggx", "object.0.material.roughness=0.3"];
    let oily = ["object.0.material.second_roughness=0.1", "object.0.material.second_share=0.25"];
    let mut smooth = session(&common);
    for (lobes, tilt) in [(&[][..], facet_tilt(0.3)), (&oily, 0.75 * facet_tilt(0.3) + 0.25 * facet_tilt(0.1))] {
        let mut rough = session(&[&common[..], &rough, lobes].concat());
        let exits = [&smooth, &rough].map(|session| f64::from(session.state().data.object_params[0].exit[0]));
        // What leaves is as bright as B says: L cos over the hemisphere, for B = 1.
        let steps = 20_000;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
        let leaves = |i: u32| 2.0 * at(i) * transmittance(1.5, facet_cosine(at(i), tilt)) * exits[1];
        let sum = (0..steps).map(leaves).sum::<f64>() / f64::from(steps);
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");

        let (before, after) = (smooth.picture().unwrap().pixels, rough.picture().unwrap().pixels);
        let mut compared = 0;
        for pixel in 0..before.len() {
            let Some(cosine) = seen_cosine(&smooth, pixel).filter(|&cosine| cosine > 0.21) else { continue };
            let factor = transmittance(1.5, facet_cosine(cosine, tilt)) / transmittance(1.5, cosine);
            let expected = f64::from(before[pixel][0]) * factor * exits[1] / exits[0];
            let found = f64::from(after[pixel][0]);
            assert!(found > 0.0 && (found / expected - 1.0).abs() < 1e-4, "{cosine}: {found} {expected}");
            compared += 1;
        }
        assert!(compared > 100, "{compared}");
    }
}

/// A uniform sky.
const WHITE: &str = "light.0={ type = 'environment', radiance = 1 }";
/// The built-in sky.
const SKY: &str = "light.0={ type = 'environment', image = 'builtin:sky' }";

#[test]
fn a_mirror_in_a_white_sky_reflects_its_fresnel_share() {
    let looks = ["object.0.material.reflection=ggx", "object.0.material.roughness=0.001"];
    let looks = [&looks[..], &["object.0.material.reflection=phong", "object.0.material.shininess=1000"]];
    for (look, slack) in looks.into_iter().zip([1e-3, 5e-2]) {
        let (mut bare, mut shiny) = (session(&[WHITE]), session(&[&[WHITE], look].concat()));
        let (bare, pixels) = (bare.picture().unwrap().pixels, shiny.picture().unwrap().pixels);
        let (data, mut off) = (&shiny.state().data, Vec::new());
        for (pixel, hit) in data.hits.iter().enumerate().filter(|(_, hit)| hit.face != u32::MAX) {
            let corners = data.triangles[hit.face as usize];
            let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
            let mix = |of: &[[f32; 3]]| -> glam::DVec3 {
                let corner = |k: usize| glam::Vec3::from(of[corners[k] as usize]) * weight[k];
                (corner(0) + corner(1) + corner(2)).as_dvec3()
            };
            let eye = (glam::Vec3::from(data.camera[0].origin).as_dvec3() - mix(&data.positions)).normalize();
            let cosine = mix(&data.normals).normalize().dot(eye);
            // Near silhouettes the width of the lobe matters.
            if cosine > 0.3 {
                // Phong's lobe keeps the cosine that a mirror drops.
                let mirror = 1.0 - transmittance(data.object_params[0].eta[0].into(), cosine);
                let expected = if data.object_params[0].reflection == 1 { mirror * cosine } else { mirror };
                let found = f64::from(pixels[pixel][0] - bare[pixel][0]);
                // A pixel draws few rays, some of them from the lobe's tail.
                off.push(found / expected - 1.0);
                assert!(off[off.len() - 1].abs() < 0.01 + 5.0 * slack, "{cosine}: {found} {expected}");
            }
        }
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        assert!(off.len() > 300 && mean.abs() < slack, "{}: {mean}", off.len());
    }
}

/// Two black mirrors of 20 mm under a white sky, the right one half hidden by nothing but the left one.
#[test]
fn a_reflection_shows_what_hides_the_environment() {
    let mirror = "material={ opaque = true, albedo = 0, eta = 5, reflection = 'ggx', roughness = 0.001 }";
    let picture = |occlusion: u32| {
        let sets = [
            format!("light.0={{ type = 'environment', radiance = 1, occlusion = {occlusion} }}"),
            format!("object.0.{mirror}"),
            format!("object.1={{ shape = 'sphere', detail = 4, size = 20, position = [24, 0, 0], {mirror} }}"),
            "object.0.detail=4".into(),
            "object.0.size=20".into(),
            "camera.position=[12, 0, 200]".into(),
            "camera.target=[12, 0, 0]".into(),
            "camera.fov=16".into(),
        ];
        let mut session = session(&sets.iter().map(String::as_str).collect::<Vec<_>>());
        (session.picture().unwrap().pixels, session.state().data.hits.clone())
    };
    let ((free, hits), (hidden, _)) = (picture(0), picture(64));
    let (mut lit, mut dark, mut expected) = (0, 0_usize, 0);
    for (pixel, _) in hits.iter().enumerate().filter(|(_, hit)| hit.face != u32::MAX) {
        if hidden[pixel][0] > 0.9 * free[pixel][0] {
            lit += 1;
        } else {
            // Of eight rays a few may pass the edge.
            assert!(hidden[pixel][0] < free[pixel][0], "{pixel}");
            dark += 1;
        }
        // The ray from the eye, mirrored at the ball that it meets, meets the other one.
        let (column, row) = ((pixel % 48) as f64 - 23.5, 19.5 - (pixel / 48) as f64);
        let up = (8f64.to_radians()).tan() / 20.0;
        let (eye, way) = (DVec3::new(12.0, 0.0, 200.0), DVec3::new(column * up, row * up, -1.0).normalize());
        let meets = |from: DVec3, way: DVec3, ball: DVec3| {
            let along = (ball - from).dot(way);
            let left = 100.0 - (ball - from - along * way).length_squared();
            (left > 0.0 && along > 0.0).then(|| from + (along - left.sqrt()) * way)
        };
        let balls = [DVec3::ZERO, DVec3::new(24.0, 0.0, 0.0)];
        let met = [0, 1].into_iter().find_map(|k| Some((k, meets(eye, way, balls[k])?)));
        if let Some((ball, point)) = met {
            let normal = (point - balls[ball]) / 10.0;
            let mirrored = way - 2.0 * way.dot(normal) * normal;
            expected += usize::from(meets(point, mirrored, balls[1 - ball]).is_some());
        }
    }
    assert!(lit > 5 * dark && dark > 10, "{lit} {dark}");
    assert!(dark.abs_diff(expected) <= 2 + expected / 5, "{dark} {expected}");
}

/// One bright pixel of an image is reflected as a sun that is as strong, by other formulas: it is a sum over rays, most
/// of which have to go to that pixel.
#[test]
fn a_bright_pixel_is_reflected_as_a_sun() {
    let (width, height, column, row) = (256, 128, 180, 45);
    let (turn, polar) = (TAU * (column as f64 + 0.5) / 256.0 - PI, PI * (row as f64 + 0.5) / 128.0);
    let toward = DVec3::new(polar.sin() * turn.sin(), polar.cos(), -polar.sin() * turn.cos());
    // 4000 times the solid angle of the pixel.
    let irradiance = 4000.0 * TAU / 256.0 * PI / 128.0 * polar.sin();
    for shape in ["'ggx', roughness = 0.5", "'phong', shininess = 9"] {
        let pictured = |light: &str, sky: Option<Sky>| {
            let black = format!("object.0.material={{ opaque = true, albedo = 0, reflection = {shape} }}");
            let sets = ["object.0.detail=3", "camera.size=[32, 32]", "camera.samples=16", light, &black];
            let mut scene = Scene::load_with("sphere", &sets.map(String::from)).unwrap();
            if let (Source::Environment { sky, .. }, Some(uneven)) = (&mut scene.lights[0].source, sky) {
                *sky = uneven;
            }
            picture(&mut Session::new(&scene, None, Options::default()).unwrap()).unwrap().pixels
        };
        let bright = || {
            let mut pixels = vec![[0.0; 3]; width * height];
            pixels[row * width + column] = [4000.0; 3];
            pixels
        };
        let [x, y, z] = toward.to_array();
        let sun = format!(
            "light.0={{ type = 'directional', direction = [{x}, {y}, {z}], irradiance = {irradiance}, shadows = false }}"
        );
        let sun = pictured(&sun, None);
        let spot = pictured(WHITE, Some(Sky::new([256, 128], bright())));
        let sum = |values: &dyn Fn(usize) -> f64| (0..sun.len()).map(values).sum::<f64>();
        let (all, found) = (sum(&|k| f64::from(sun[k][1])), sum(&|k| f64::from(spot[k][1])));
        assert!((found / all - 1.0).abs() < 0.02, "{shape}: {found} {all}");
        let square = sum(&|k| f64::from(sun[k][1]).powi(2));
        let off = |seen: &[[f32; 3]]| (sum(&|k| f64::from(seen[k][1] - sun[k][1]).powi(2)) / square).sqrt();
        assert!(off(&spot) < 0.3, "{shape}: {}", off(&spot));
        // As a light of its own it is reflected once, without grain.
        let alone = pictured(WHITE, Some(Sky::new([256, 128], bright()).with_sun()));
        assert!(off(&alone) < 0.01, "{shape}: {}", off(&alone));
    }
}

#[test]
fn further_samples_bring_a_reflection_nearer_to_its_mean() {
    let error = |shape: &str, samples: u32, mean: &[[f32; 3]]| {
        let camera = format!(
            "camera={{ position = [0, 0, 25], target = [0, 0, 0], fov = 20, samples = {samples}, size = [16, 16] }}"
        );
        let sky = "light.0={ type = 'environment', image = 'builtin:studio' }";
        let black = format!("object.0.material={{ opaque = true, albedo = 0, reflection = {shape} }}");
        let picture = picture(&mut session(&[sky, &black, &camera, "object.0.size=20"])).unwrap().pixels;
        let off = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(a[1] - b[1]).powi(2);
        (picture.iter().zip(mean).map(off).sum::<f64>().sqrt(), picture)
    };
    for shape in ["'ggx', roughness = 0.3", "'phong', shininess = 20"] {
        let (_, mean) = error(shape, 64, &[]);
        // 32 rays, and 128 of the 512.
        let [one, sixteen] = [1, 16].map(|samples| error(shape, samples, &mean).0);
        assert!(one > 0.0 && sixteen < 0.6 * one, "{shape}: {one} {sixteen}");
    }
}

#[test]
fn a_highlight_stands_where_the_sun_is_mirrored_and_not_in_shadow() {
    // The sun behind the camera, a little above; then on the other side of the ball.
    let sun = |direction: &str| format!("light.0.direction={direction}");
    let black = "object.0.material={ opaque = true, albedo = 0 }";
    let looks = ["camera.position=[0, 0, 45]", "object.0.size=20", black, "object.0.material.reflection=ggx"];
    let gain = |direction: &str| {
        let sun = sun(direction);
        let bare = session(&[&looks[..3], &[sun.as_str()]].concat()).picture().unwrap().pixels;
        let shiny = session(&[&looks[..], &[sun.as_str()]].concat()).picture().unwrap().pixels;
        bare.iter().zip(&shiny).map(|(a, b)| b[1] - a[1]).collect::<Vec<_>>()
    };
    let front = gain("[0, 0.6, 1]");
    let brightest = (0..front.len()).max_by(|&a, &b| front[a].total_cmp(&front[b])).unwrap();
    let (column, row) = (brightest % 48, brightest / 48);
    assert!((22..=25).contains(&column) && (9..19).contains(&row) && front[brightest] > 0.1, "{column} {row}");
    assert!(gain("[0, 0, -1]").iter().all(|&more| more == 0.0));
}

#[test]
fn the_environment_stands_behind_the_object() {
    let mut seen = session(&[SKY, "camera.background=environment", "camera.position=[0, 0, 60]"]);
    let pixels = seen.picture().unwrap().pixels;
    let hits = &seen.state().data.hits;
    // Blue above, darker below; brighter towards +x.
    let (top, bottom) = (pixels[24], pixels[39 * 48 + 24]);
    assert!(hits[24].face == u32::MAX && top[2] > bottom[2] && bottom[2] > 0.0, "{top:?} {bottom:?}");
    assert!(pixels[20 * 48 + 47][0] > pixels[20 * 48][0]);
}

#[test]
fn a_transparent_picture_before_any_background_is_the_picture_with_it() {
    for samples in ["camera.samples=1", "camera.samples=5"] {
        let render = |background: &str| {
            let mut session = session(&[samples, &format!("camera.background={background}")]);
            picture(&mut session).unwrap()
        };
        let (clear, black, green) = (render("none"), render("0"), render("[0, 2, 0]"));
        let alpha = clear.alpha.unwrap();
        assert!(black.alpha.is_none() && clear.pixels == black.pixels);
        assert_eq!((alpha[0], alpha[20 * 48 + 24]), (0.0, 1.0));
        let edges = alpha.iter().filter(|&&a| a > 0.0 && a < 1.0).count();
        assert_eq!(edges > 40, samples.ends_with('5'), "{edges} pixels at the edge");
        for ((clear, alpha), green) in clear.pixels.iter().zip(alpha).zip(&green.pixels) {
            let composed = clear[1] + (1.0 - alpha) * 2.0;
            assert!((composed - green[1]).abs() < 1e-5 && clear[0] == green[0], "{clear:?} {alpha} {green:?}");
        }
    }
}

#[test]
fn a_reflection_in_two_lobes_is_the_mean_of_both() {
    let pixels = |lobes: &str| {
        let look = format!("object.0.material={{ opaque = true, albedo = 0, eta = 1.3, reflection = 'ggx', {lobes} }}");
        session(&["light.0.direction=[0.2, 0.6, 1]", &look]).picture().unwrap().pixels
    };
    let both = pixels("roughness = 0.45, second_roughness = 0.25, second_share = 0.3");
    let (wide, narrow) = (pixels("roughness = 0.45"), pixels("roughness = 0.25"));
    let mut apart = 0;
    for ((both, wide), narrow) in both.iter().zip(&wide).zip(&narrow) {
        let mean = 0.7 * wide[1] + 0.3 * narrow[1];
        assert!((both[1] - mean).abs() < 1e-5 * mean.max(1.0), "{both:?} {wide:?} {narrow:?}");
        apart += u32::from((wide[1] - narrow[1]).abs() > 0.01 * mean);
    }
    assert!(apart > 100, "the lobes look alike at all but {apart} pixels");
    let half = pixels("roughness = 0.45, second_roughness = 0.25");
    assert!(half == pixels("roughness = 0.45, second_roughness = 0.25, second_share = 0.5") && half != both);
}

/// The share of each pixel of the middle row that shows a plane which faces the camera at this distance and ends in the
/// middle of the picture.
fn edge(distance: f64, lens: &str) -> Vec<f32> {
    let sets = [
        "object.0={ shape = 'plane', detail = 1, size = 40, rotation = [90, 0, 0], position = [20, 0, 0], \
         material = { opaque = true } }"
            .to_string(),
        format!(
            "camera={{ position = [0, 0, {distance}], target = [0, 0, 0], fov = 8, size = [64, 8], samples = 64, background = 'none', {lens} }}"
        ),
    ];
    let mut session = Session::new(&Scene::load_with("sphere", &sets).unwrap(), None, Options::default()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let alpha = picture(&mut session).unwrap().alpha.unwrap();
    alpha[4 * 64..5 * 64].to_vec()
}

#[test]
fn a_lens_blurs_by_its_circle_of_confusion() {
    let sharp = edge(20.0, "aperture = 0");
    assert!(sharp[..32].iter().all(|&a| a == 0.0) && sharp[32..].iter().all(|&a| a == 1.0), "{sharp:?}");
    // What is in focus stays sharp and where it is, by default the target.
    for lens in ["aperture = 5", "aperture = 5, focus = 20"] {
        assert_eq!(edge(20.0, lens), sharp, "{lens}");
    }
    // Behind and before what is in focus: pixels within the circle are covered by its segment.
    for focus in [10.0, 40.0_f64] {
        let blurred = edge(20.0, &format!("aperture = 5, focus = {focus}"));
        let pixels_at = 8.0 / (2.0 * 20.0 * 4f64.to_radians().tan());
        let radius = 0.5 * 5.0 * (20.0 - focus).abs() / focus * pixels_at;
        for (column, alpha) in blurred.iter().enumerate() {
            let x = ((column as f64 - 31.5) / radius).clamp(-1.0, 1.0);
            let covered = 0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / PI;
            // 64 samples, and half a pixel where the slope is steepest.
            let slack = 0.05 + 1.0 / (PI * radius);
            assert!((f64::from(*alpha) - covered).abs() < slack, "{focus}: {column} {alpha} {covered}");
        }
        assert!(blurred.iter().filter(|&&a| a > 0.0 && a < 1.0).count() as f64 > 2.0 * radius - 2.0);
    }
}

/// The pixels of an EXR file that has alpha.
fn rgba(path: &std::path::Path) -> Vec<[f32; 4]> {
    let make = |size: exr::prelude::Vec2<usize>, _: &_| vec![vec![[0.0; 4]; size.width()]; size.height()];
    let set = |rows: &mut Vec<Vec<[f32; 4]>>, at: exr::prelude::Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
        rows[at.y()][at.x()] = [r, g, b, a];
    };
    let image = exr::prelude::read_first_rgba_layer_from_file(path, make, set).unwrap();
    image.layer_data.channel_data.pixels.concat()
}

#[test]
fn a_png_has_straight_alpha_and_an_exr_premultiplied() {
    let here = folder(&[("odd.toml", "[camera]\n\nbackground = 'nothing'\n")]);
    let ball = "render sphere --set object.0.detail=2 --device cpu --size 24x20 --samples 4";
    for end in ["png", "exr"] {
        good(&here, &format!("{ball} --background none -o a.{end}"));
    }
    good(&here, &format!("{ball} --background none --aov -o layers.exr"));
    good(&here, &format!("{} --background none -o device.png", ball.replace("--device cpu ", "")));
    let png = image::open(here.path().join("a.png")).unwrap();
    assert_eq!(png.color(), image::ColorType::Rgba8);
    let png = png.into_rgba8();
    let exr = rgba(&here.path().join("a.exr"));
    let mut edges = 0;
    for (shown, linear) in png.pixels().zip(exr) {
        let alpha = linear[3];
        assert_eq!(shown.0[3], (alpha * 255.0 + 0.5) as u8);
        edges += u32::from(alpha > 0.0 && alpha < 1.0);
        for c in 0..3 {
            let straight = if alpha > 0.0 { linear[c] / alpha } else { 0.0 };
            let wanted = (255.0 * milkglass::internals::view::picture::encode(straight.into()) + 0.5) as u8;
            assert!(shown.0[c].abs_diff(wanted) <= 1, "{shown:?} {linear:?}");
        }
    }
    assert!(edges > 15 && png.get_pixel(0, 0).0 == [0; 4] && png.get_pixel(12, 10).0[3] == 255, "{edges}");
    let device = image::open(here.path().join("device.png")).unwrap().into_rgba8();
    assert!(device.pixels().zip(png.pixels()).all(|(a, b)| a.0[3] == b.0[3]), "a device covers other pixels");
    let layers = exr::prelude::read_all_flat_layers_from_file(here.path().join("layers.exr")).unwrap();
    let first = &layers.layer_data[0];
    let names: Vec<String> = first.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "R"]);
    bad(&here, "render odd.toml -o b.png", 2, &["odd.toml:3: ", "\"environment\" or \"none\""]);
    bad(&here, &format!("{ball} --background clear -o b.png"), 2, &["camera.background=clear", "found string"]);
}

#[test]
fn a_filmic_picture_keeps_its_highlights_and_exr_stays_linear() {
    let here = folder(&[]);
    for tone in ["clip", "filmic"] {
        let look = format!("--set camera.tone={tone} --set light.0.irradiance=30 --set camera.size=[24,20]");
        for end in ["png", "exr"] {
            good(&here, &format!("render sphere --set object.0.detail=1 --device cpu {look} -o {tone}.{end}"));
        }
    }
    let white = |name: &str| {
        let picture = image::open(here.path().join(name)).unwrap().to_rgb8();
        picture.pixels().filter(|pixel| pixel.0 == [255; 3]).count()
    };
    assert!(white("clip.png") > 20 && white("filmic.png") < white("clip.png") / 2);
    assert_eq!(bytes(&here, "clip.exr"), bytes(&here, "filmic.exr"));
}

#[test]
fn bad_looks_are_named() {
    let here = folder(&[]);
    let cases: &[(&str, &[&str])] = &[
        ("object.0.material.roughness=0.3", &["object.0.material.roughness", "found reflection = \"none\"", "\"ggx\""]),
        ("object.0.material.reflection=gloss", &["unknown value", "found gloss", "expected none, phong, ggx"]),
        ("object.0.material={preset='apple',reflection='ggx',roughness=0}", &["roughness", "found 0", "0.001 to 1"]),
        (
            "object.0.material={preset='apple',reflection='phong',shininess=1001}",
            &["shininess", "found 1001", "a whole number from 1 to 1000"],
        ),
        ("object.0.material.second_roughness=0.3", &["second_roughness", "found reflection = \"none\"", "\"ggx\""]),
        (
            "object.0.material={preset='skin1',reflection='ggx',second_share=0.3}",
            &["material.second_share: the share of a lobe that is missing", "found 0.3", "second_roughness beside it"],
        ),
        (
            "object.0.material={preset='skin1',reflection='ggx',second_roughness=2}",
            &["material.second_roughness: out of range", "found 2", "0.001 to 1"],
        ),
        (
            "object.0.material={preset='skin1',reflection='ggx',second_roughness=0.2,second_share=1.5}",
            &["material.second_share: out of range", "found 1.5", "expected 0 to 1"],
        ),
        ("object.0.material.normalize_exit=3", &["invalid type", "found integer `3`", "expected"]),
        ("camera.background=environment", &["camera.background: no light is an environment", "[[light]] of type"]),
        ("camera.background=sky", &["found string \"sky\"", "a number, [r, g, b], \"environment\" or \"none\""]),
        ("camera.tone=flimic", &["unknown value, did you mean `filmic`?", "found flimic", "expected clip, filmic"]),
        ("camera.background=[1,2]", &["invalid length 2"]),
        ("camera.background=-1", &["camera.background: out of range; found [-1, -1, -1]"]),
    ];
    for (set, words) in cases {
        bad(&here, &format!("render sphere --device cpu --set {set} -o a.png"), 2, words);
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_plan_has_no_look_that_is_not_asked_for() {
    let here = folder(&[]);
    let plan = |sets: &str| {
        good(&here, &format!("plan sphere --set object.0.detail=1 --device cpu {sets} --json a.json"));
        let plan: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
        let has = |list: &str, key: &str, name: &str| plan[list].as_array().unwrap().iter().any(|row| row[key] == name);
        let stage = |name: &str| has("stages", "stage", name);
        [stage("reflect"), stage("backdrop"), stage("pixel_shadow"), has("buffers", "buffer", "sky")]
    };
    let sky = "--set light.1={type='environment',radiance=1}";
    let hidden = "--set light.1={type='environment',radiance=1,occlusion=8}";
    let (ggx, seen) = ("--set object.0.material.reflection=ggx", "--set camera.background=environment");
    assert_eq!(plan(""), [false; 4]);
    assert_eq!(plan(ggx), [true, false, true, false]);
    assert_eq!(plan(sky), [false, false, false, true]);
    assert_eq!(plan(&format!("{sky} {ggx}")), [true, false, true, true]);
    // Rays are traced only where something can hide the environment, and something reflects it.
    let unshadowed = "--set light.0.shadows=false";
    assert_eq!(plan(&format!("{sky} {unshadowed} {ggx}")), [true, false, false, true]);
    assert_eq!(plan(&format!("{hidden} {unshadowed} {ggx}")), [true, false, true, true]);
    assert_eq!(plan(&format!("{hidden} {unshadowed}")), [false, false, false, true]);
    assert_eq!(plan(&format!("{sky} {seen}")), [false, true, false, true]);
    assert_eq!(plan(&format!("{ggx} --set light.0.irradiance=0")), [false; 4]);
}

#[test]
fn samples_bring_a_pixel_near_its_mean() {
    // The expected pixels, from a picture with 8 x 8 times the pixels.
    let mut fine = session(&["camera.size=[384, 320]"]);
    let fine = fine.picture().unwrap();
    let mean = |pixel: usize| -> f64 {
        let (column, row) = (pixel % 48 * 8, pixel / 48 * 8);
        (0..64).map(|k| f64::from(fine.pixels[(row + k / 8) * 384 + column + k % 8][1])).sum::<f64>() / 64.0
    };
    let error = |samples: &str| {
        let picture = picture(&mut session(&[samples])).unwrap();
        let off = |(k, pixel): (usize, &[f32; 3])| (f64::from(pixel[1]) - mean(k)).powi(2);
        picture.pixels.iter().enumerate().map(off).sum::<f64>().sqrt()
    };
    let (one, sixteen) = (error("camera.samples=1"), error("camera.samples=16"));
    assert!(sixteen < 0.25 * one && one > 0.0, "{sixteen} {one}");
    // One sample gives the plain picture, bit for bit.
    assert_eq!(picture(&mut session(&[])).unwrap().pixels, session(&[]).picture().unwrap().pixels);
}

#[test]
fn a_session_renders_what_the_camera_asks_for() {
    let sets = ["camera.samples=3", "camera.exposure=2", "camera.tone=filmic"];
    let mut rendered = session(&sets);
    let first = rendered.render().unwrap();
    assert_eq!(first.pixels, picture(&mut session(&sets)).unwrap().pixels);
    let centres = session(&sets).picture().unwrap().pixels;
    assert_ne!(first.pixels, centres);
    assert_eq!((first.exposure, first.tone), (2.0, milkglass::scene::Tone::Filmic));
    // Afterwards rays run through the pixels' centres again.
    rendered.frame(Default::default()).unwrap();
    assert_eq!(rendered.picture().unwrap().pixels, centres);
    assert_eq!(rendered.render().unwrap().pixels, first.pixels);
    // Without a frame after another camera there is a picture of its size all the same.
    let mut one = rendered.scene().camera.clone();
    (one.samples, one.size) = (1, [5, 4]);
    rendered.set_camera(&one).unwrap();
    assert_eq!(rendered.picture().unwrap().pixels.len(), 20);
}

#[test]
fn the_number_of_samples_is_checked() {
    let here = folder(&[]);
    for (samples, found) in [("0", "found 0"), ("65", "found 65")] {
        let line = format!("render sphere -o a.png --set camera.samples={samples}");
        bad(&here, &line, 2, &["camera.samples", found, "1 to 64"]);
    }
}
