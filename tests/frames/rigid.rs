//! Objects that are turned and shifted: light is carried in their own frames.

use super::modes::{names, scene};
use crate::devices::on_devices;
use milkglass::internals::gpu::Device;
use milkglass::internals::layout::BUFFER_IDS;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options};
use milkglass::internals::session::run::Session;

/// Two objects, the second with this rotation and position.
fn two(more: &[&str], rotation: &str, position: &str) -> milkglass::Scene {
    let base = [
        "object.0.detail=2",
        "object.1={ shape = 'slab', detail = 2, size = 9, material = { preset = 'ketchup' } }",
        "camera.size=[16, 16]",
        "transport.receivers=faces",
        "light.0.shadows=false",
    ];
    let placement = [format!("object.1.rotation={rotation}"), format!("object.1.position={position}")];
    scene("sphere", &[&base[..], &[&placement[0], &placement[1]], more].concat())
}

fn run(scene: &milkglass::Scene, device: Option<&Device>, mode: Mode) -> Session {
    let options = Options { mode, goal: Goal::Picture, ..Options::default() };
    let mut session = Session::new(scene, device, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

#[test]
fn a_moved_object_has_the_same_clusters_links_and_form_factors() {
    let same = |device: Option<&Device>| {
        for (scheme, mode) in [("links", Mode::Keep), ("blocks", Mode::Render)] {
            let scheme = format!("transport.scheme={scheme}");
            let placed = |rotation: &str, position: &str| {
                let scene = two(&[&scheme], rotation, position);
                let mut session = run(&scene, device, mode);
                session.fetch(BUFFER_IDS).unwrap();
                session
            };
            let (one, other) = (placed("[10, 20, 30]", "[12, 3, 0]"), placed("[-70, 45, 5]", "[11, -6, 4]"));
            assert!(one.state().data.placed_positions != other.state().data.placed_positions, "nothing moved");
            for object in 0..2 {
                // Values between the objects' parts do not count.
                let [a, b] = [&one, &other].map(|session| session.state().alone(object).data);
                assert!(a.positions == b.positions && a.clusters == b.clusters && a.spheres == b.spheres, "{scheme}");
            }
            let (a, b) = (&one.state().data, &other.state().data);
            if mode == Mode::Keep && device.is_none() {
                assert!(!a.links.is_empty() && !a.factors.is_empty());
                assert!(a.links == b.links && a.factors == b.factors, "links");
            }
        }
    };
    same(None);
    on_devices(|device| same(Some(device)));
}

#[test]
fn a_motion_runs_what_it_touches() {
    let after = |mode: Mode, more: &[&str], rotation: &str, position: &str| {
        let mut session = run(&two(more, "[10, 20, 30]", "[12, 3, 0]"), None, mode);
        session.show(&two(more, rotation, position)).unwrap();
        names(&mut session, Change::default())
    };
    let count = |names: &[String], name: &str| names.iter().filter(|own| *own == name).count();

    // Turned where no light casts shadows: only its own light, the lists for any light stay.
    let turned = after(Mode::Render, &[], "[10, 21, 30]", "[12, 3, 0]");
    let own = [
        "placement",
        "widen",
        "visibility",
        "irradiance",
        "pull",
        "coarse_solve",
        "irradiance_ratio",
        "gather",
        "push",
        "average",
        "shade",
    ];
    assert_eq!(turned, own);
    // Shifted, so that the middle of the scene is another one.
    let shifted = after(Mode::Render, &[], "[10, 20, 30]", "[12, 4, 0]");
    assert_eq!([count(&shifted, "placement"), count(&shifted, "irradiance"), count(&shifted, "link")], [2, 2, 0]);
    // Its shadow falls on the other one.
    let shadows = after(Mode::Render, &["light.0.shadows=true"], "[10, 21, 30]", "[12, 3, 0]");
    assert_eq!([count(&shadows, "shadow"), count(&shadows, "irradiance"), count(&shadows, "refit")], [1, 2, 0]);
    // Kept links stay, whatever moves.
    let links = after(Mode::Incremental, &["transport.scheme=links"], "[10, 21, 30]", "[12, 3, 1]");
    let linked = ["refit", "refine", "form_factor", "update_links", "update_form_factors", "mark_moved"];
    assert!(linked.iter().all(|name| count(&links, name) == 0), "{links:?}");
    assert!(count(&links, "sum_links") + count(&links, "resum_links") > 0, "{links:?}");
}

#[test]
fn an_object_that_is_neither_turned_nor_shifted_has_no_placement() {
    let session = run(&scene("sphere", &["object.0.detail=1", "object.0.position=[3, 4, 5]"]), None, Mode::OnTheFly);
    let why = session.plan().left_out.iter().find(|(name, _)| *name == "placement").map(|(_, why)| &why[..]);
    assert_eq!(why, Some("no object is turned or shifted"));
    assert!(session.state().data.placed_positions.is_empty());
}

#[test]
fn faces_lie_where_the_object_was_put() {
    // A quarter turn about z, then a shift: x goes to y.
    let sets = ["object.0.detail=1", "object.0.rotation=[0, 0, 90]", "object.0.position=[1, 2, 3]"];
    let mut rest = run(&scene("slab", &sets[..1]), None, Mode::OnTheFly);
    let mut moved = run(&scene("slab", &sets), None, Mode::OnTheFly);
    let (rest, moved) = (rest.faces().unwrap(), moved.faces().unwrap());
    assert_eq!(rest.len(), moved.len());
    for (rest, moved) in rest.iter().zip(&moved) {
        let wanted = glam::DVec3::new(1.0 - rest.center.y, 2.0 + rest.center.x, 3.0 + rest.center.z);
        assert!(moved.center.distance(wanted) < 1e-9, "{} is not at {wanted}", moved.center);
    }
}
