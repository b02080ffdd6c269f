//! `render --view clusters`: the emitters of one receiver cover every lit triangle once.

use crate::shell::{bad, folder, good};
use milkglass::internals::pipeline::plan::{Change, Mode, Options};
use milkglass::internals::session::cluster_view::clusters;
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn emitters_settle_every_lit_triangle_once() {
    let middle = [20, 15];
    for set in ["transport.receivers=faces", "transport.receivers=pixels", "transport.scheme=links"] {
        let sets = ["object.0.detail=4", "camera.size=[40, 30]", set].map(String::from);
        let scene = Scene::load_with("sphere", &sets).unwrap();
        let options = Options { mode: Mode::Render, ..Options::default() };
        let mut session = Session::new(&scene, None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let (picture, emitters) = clusters(&mut session, middle).unwrap();

        let state = session.state();
        let settled = emitters.of_face.iter().filter(|emitter| emitter.is_some()).count();
        let inside: usize = emitters.levels.values().map(|(_, triangles)| triangles).sum();
        assert_eq!(settled, inside, "{set}: an emitter in another");
        // Triangles that no emitter covers are too faint to matter.
        let shines = |face: usize| state.data.irradiance[face].map(f64::from).iter().sum::<f64>();
        let all: f64 = (0..emitters.of_face.len()).map(shines).sum();
        let missed: f64 =
            (0..emitters.of_face.len()).filter(|&face| emitters.of_face[face].is_none()).map(shines).sum();
        assert!(missed <= 1e-3 * all, "{set}: {missed} of {all} shine and are nobody's");
        // Near triangles are listed individually, far ones as clusters.
        let (clusters, levels) = (emitters.levels.values().map(|level| level.0).sum::<usize>(), emitters.levels.len());
        assert!(clusters < inside && levels > 3, "{set}: {:?}", emitters.levels);

        // The receiver is shown in white, the other triangles in the colours of their emitters.
        let at = picture.pixels[(middle[1] * 40 + middle[0]) as usize];
        assert!(at[0] == at[1] && at[1] == at[2] && at[0] > 0.5, "{set}: {at:?}");
        let colors = picture.pixels.iter().filter(|p| p[0] != p[2]).map(|p| p.map(f32::to_bits));
        assert!(colors.collect::<std::collections::HashSet<_>>().len() > 20, "{set}");
    }
}

#[test]
fn what_cannot_be_shown_is_said() {
    let here = folder(&[]);
    let ball = "render sphere --set object.0.detail=2 --size 40x30 --device cpu -o a.png";
    good(&here, &format!("{ball} --view clusters --pick 20,15"));
    good(&here, &format!("{ball} --view clusters --pick 20,15 --set transport.scheme=links --set light=[]"));
    let opaque = "--set object.0.material={opaque=true,albedo=[1,1,1]}";
    for (arguments, message) in [
        ("--view clusters", "--pick"),
        ("--pick 1,2", "--view"),
        ("--view clusters --pick 20", "expected X,Y"),
        ("--view clusters --pick 40,0", "outside the picture; found 40,0; expected 0 to 39 and 0 to 29"),
        ("--view clusters --pick 0,0", "the pixel shows nothing"),
        (&*format!("--view clusters --pick 20,15 {opaque}"), "opaque"),
        ("--view clusters --pick 20,15 --transport brute", "only the hierarchy"),
        ("--view clusters --pick 20,15 --aov", "cannot be used with"),
    ] {
        bad(&here, &format!("{} {arguments}", ball.replace("a.png", "b.png")), 2, &[message]);
        assert!(!here.path().join("b.png").exists(), "{arguments}");
    }
}
