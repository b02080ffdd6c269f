//! Local shading under an environment: which objects keep its light away.

use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

#[test]
fn what_hides_the_sky_above_darkens_and_what_hides_it_below_does_not() {
    // Seen from above, an opaque plate over or under the middle of a floor that the sky alone lights.
    let floor = [
        "object.0.shape=plane",
        "object.0.size=20",
        "object.0.detail=2",
        "object.0.rotation=[0, 0, 0]",
        "object.0.material={ preset = 'marble', sigma_0 = 0, eta = 1 }",
        "light=[{ type = 'environment', radiance = 1, occlusion = 256 }]",
        "camera={ position = [0, 30, 0.1], target = [0, 0, 0], size = [8, 8], fov = 10, background = 0 }",
    ];
    let sum = |plate: &str| {
        let sets: Vec<String> = floor.iter().chain(&[plate]).map(ToString::to_string).collect();
        let options = Options { transport: ShadingMethod::Lambert, ..Options::default() };
        let mut session = Session::new(&Scene::load_with("sphere", &sets).unwrap(), None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.picture().unwrap().pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>()
    };
    let at = |y: f64| {
        format!("object.1={{ shape = 'plane', size = 400, position = [0, {y}, 0], material = {{ opaque = true }} }}")
    };
    let (below, far) = (sum(&at(-2.0)), sum(&at(-500.0)));
    assert!(far > 0.0 && (below / far - 1.0).abs() < 1e-3, "{below} {far}");
    assert!(sum(&at(40.0)) < 0.1 * far, "{} {far}", sum(&at(40.0)));
}
