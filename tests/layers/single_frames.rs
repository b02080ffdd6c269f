//! Light scattered once in the medium: beside each method, after changes, in plans, and where it is refused.

use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use super::{scene, session};
use crate::shell::{bad, folder, good};

const ASKS: &str = "object.0.material.single_scattering=true";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn it_is_added_to_each_method_alike() {
    let small = ["object.0.detail=3", "camera.size=[24, 24]", "camera.background=0"];
    let picture = |sets: &[&str], transport| {
        let options = Options { transport, ..Options::default() };
        session(&scene("sphere", &[&small[..], sets].concat()), options).picture().unwrap().pixels
    };
    let once = picture(&[ASKS], ShadingMethod::None);
    assert!(once.iter().any(|pixel| pixel[0] > 0.01) && once.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    for (sets, transport) in [
        (&[][..], ShadingMethod::Hierarchy),
        (&["transport.receivers=faces"], ShadingMethod::Hierarchy),
        (&["transport.scheme=links"], ShadingMethod::Hierarchy),
        (&[], ShadingMethod::Octree),
        (&[], ShadingMethod::Brute),
        (&[], ShadingMethod::Cdrf),
    ] {
        let (without, with) = (picture(sets, transport), picture(&[sets, &[ASKS]].concat(), transport));
        // Self-shadows at the terminator are not part of the CDRF.
        let close = if transport == ShadingMethod::Cdrf { 2e-2 } else { 1e-5 };
        for ((without, with), once) in without.iter().zip(&with).zip(&once) {
            for c in 0..3 {
                assert!((with[c] - without[c] - once[c]).abs() < close, "{transport:?}: {without:?} {with:?} {once:?}");
            }
        }
    }
}

#[test]
fn a_change_of_material_is_that_of_a_new_session() {
    let small = ["object.0.detail=2", "camera.size=[16, 16]"];
    let with = |sets: &[&str]| scene("sphere", &[&small[..], sets].concat());
    let mut session = session(&with(&[ASKS]), Options::default());
    for sets in [
        &[ASKS, "object.0.material.g=0.5"][..],
        &[ASKS, "object.0.material.sigma_a=0.3"],
        &[ASKS, "object.0.material.eta=[1.2, 1.3, 1.3]"],
        &[],
        &[ASKS, "object.0.size=3"],
        &[ASKS, "light.0.direction=[-1, 0.3, 0.2]"],
    ] {
        let next = with(sets);
        session.show(&next).unwrap();
        let expected = Session::new(&next, None, Options::default()).unwrap().render().unwrap();
        assert!(session.render().unwrap().pixels == expected.pixels, "{sets:?}");
    }
}

#[test]
fn a_plan_says_why_it_is_left_out_and_a_frame_without_it_has_nothing_of_it() {
    let here = folder(&[]);
    let small = "--set object.0.detail=2 --set camera.size=[8,8]";
    let (said, _) = good(&here, &format!("plan sphere {small}"));
    assert!(said.contains("no material has single_scattering = true"), "{said}");
    let (said, _) = good(&here, &format!("plan sphere {small} --set {ASKS} --transport lambert"));
    assert!(said.contains("single_scattering"), "{said}");
    let own = [BufferId::scattering_media, BufferId::inner_rays, BufferId::layer_lights];
    let bytes = |sets: &[&str], goal| {
        let options = Options { goal, ..Options::default() };
        let mut session = Session::new(&scene("sphere", sets), None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        own.map(|slot| session.state().data.bytes(slot).len())
    };
    assert_eq!(bytes(&["object.0.detail=2"], Goal::Picture), [0; 3]);
    assert_eq!(bytes(&["object.0.detail=2", ASKS], Goal::Radiosity), [0; 3]);
    assert!(bytes(&["object.0.detail=2", ASKS], Goal::Picture).iter().all(|&bytes| bytes > 0));
}

#[test]
fn it_is_refused_where_it_has_no_meaning() {
    let here = folder(&[]);
    let small = "--set object.0.detail=2 --set camera.size=[8,8]";
    let words = [
        "object.0.material.single_scattering",
        "random walk and diffusion hold the light",
        "another --transport than walk or diffusion",
    ];
    bad(&here, &format!("render sphere {small} --set {ASKS} --transport walk -o a.png"), 2, &words);
    let cases = [
        ("{ preset = 'marble', single_scattering = true, two_sided = true }", "object.0.material.two_sided: light is"),
        (
            "{ preset = 'marble', single_scattering = true, texture = 'builtin:tiles', texture_on = 'both' }",
            "object.0.material.texture_on: a texture changes light that is scattered once only where it leaves",
        ),
        (
            "{ preset = 'marble', single_scattering = true, layers = { layer = [{ sigma_s = 1, sigma_t = 2, thickness = 1 }] } }",
            "object.0.material.layers: light scatters once in the layers",
        ),
        (
            "{ opaque = true, single_scattering = true }",
            "object.0.material.single_scattering: an opaque material has no",
        ),
    ];
    for (material, message) in cases {
        let sets = [format!("object.0.material={material}")];
        let error = Scene::load_with("sphere", &sets).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(message), "{error}");
    }
}
