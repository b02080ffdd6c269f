//! Stages and buffers that only some frames have, each with a frame that has them and one that has not.

use milkglass::internals::layout::{BufferId, LINK_KEPT, Runs};
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::{Deform, Light, Pose, Receivers, Reflection, Rig, Scene};
use std::sync::Arc;

fn small(name: &str, sets: &[&str]) -> Scene {
    let all = [sets, &["camera.size=[24, 20]"]].concat();
    Scene::load_with(name, &all.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap()
}

pub fn ball(sets: &[&str]) -> Scene {
    small("sphere", &[&["object.0.detail=2", "transport.receivers=faces"], sets].concat())
}

pub type Case = (Scene, Options);

fn with(scene: Scene) -> Case {
    (scene, Options::default())
}

fn changed(mut scene: Scene, change: impl Fn(&mut Scene)) -> Case {
    change(&mut scene);
    with(scene)
}

fn carried(transport: ShadingMethod) -> Case {
    (ball(&[]), Options { transport, ..Options::default() })
}

/// A ball that a joint turns.
fn turned() -> Case {
    changed(ball(&[]), |scene| {
        let base = scene.objects[0].mesh.positions.clone();
        let count = base.len();
        let rig = Rig { base, joints: 1, influences: vec![(0, 1.0); count], rows: vec![0; count], ..Rig::default() };
        let pose = Pose { matrices: vec![glam::DMat4::from_rotation_z(0.1)], weights: Vec::new() };
        scene.objects[0].deforms.push(Deform::Skin { rig: Arc::new(rig), pose: Arc::new(pose) });
    })
}

fn sky(background: &str) -> Case {
    with(ball(&["light.0={type='environment',radiance=1}", &format!("camera.background={background}")]))
}

fn tiles(side: &str) -> Case {
    with(ball(&["object.0.material.texture=builtin:tiles", &format!("object.0.material.texture_on={side}")]))
}

fn on_a_table(receivers: &str) -> Scene {
    small("candle", &["object.0.detail=16", &format!("transport.receivers={receivers}")])
}

/// Without opaque objects.
fn alone(scene: Scene) -> Case {
    changed(scene, |scene| scene.objects.retain(|object| object.material.opaque.is_none()))
}

fn reflects(reflection: Reflection) -> Case {
    changed(ball(&[]), move |scene| scene.objects[0].material.surface.reflection = reflection)
}

fn options(options: Options) -> Case {
    (ball(&[]), options)
}

/// Without a picture.
fn unseen(sets: &[&str]) -> Case {
    (ball(sets), Options { goal: Goal::Radiosity, ..Options::default() })
}

fn links() -> Case {
    with(ball(&["transport.scheme=links"]))
}

fn incremental(mode: Mode) -> Case {
    let scene = ball(&["transport.scheme=links", "transport.budget=9000", "object.0.deform=[{type='twist',angle=30}]"]);
    (scene, Options { mode, ..Options::default() })
}

fn blurred(transport: ShadingMethod) -> Case {
    (ball(&["transport.unwrap=true", "transport.blur_texture=32"]), Options { transport, ..Options::default() })
}

fn local(cdrf: &str) -> Case {
    let scene = ball(&[&format!("transport.cdrf={cdrf}"), "transport.cdrf_table=16"]);
    (scene, Options { transport: ShadingMethod::Cdrf, ..Options::default() })
}

/// Stages, buffers, a frame with the feature, a frame without it.
pub type Feature = (&'static [&'static str], &'static [BufferId], Case, Case);

/// Each feature: the stages and buffers that only it needs, a frame with it, and the same frame without it.
pub fn features() -> Vec<Feature> {
    [scenes(), pictures(), lists(), transports(), shading()].concat()
}

/// Of lights, materials and shapes.
fn scenes() -> Vec<Feature> {
    let layered = || small("slab-layers", &["object.0.detail=4"]);
    let twisted = ball(&["object.0.deform=[{type='twist',angle=30}]"]);
    vec![
        (&["shadow"], &[BufferId::lit, BufferId::cut_short], with(ball(&[])), with(ball(&["light.0.shadows=false"]))),
        (&["environment"], &[BufferId::sky, BufferId::harmonics], sky("[0,0,0]"), with(ball(&[]))),
        (&["backdrop"], &[], sky("environment"), sky("[0,0,0]")),
        (&["texture_in"], &[BufferId::texels, BufferId::corner_uvs], tiles("entry"), with(ball(&[]))),
        (&["texture_out"], &[BufferId::texels, BufferId::corner_uvs], tiles("exit"), with(ball(&[]))),
        (
            &["plane_fit", "relief"],
            &[
                BufferId::layerings,
                BufferId::layer_media,
                BufferId::planes,
                BufferId::vertex_moments,
                BufferId::layer_lights,
            ],
            with(layered()),
            changed(layered(), |scene| scene.objects[0].material.layers = None),
        ),
        (
            &["single_scattering"],
            &[BufferId::scattering_media, BufferId::inner_rays, BufferId::layer_lights],
            with(ball(&["object.0.material.single_scattering=true"])),
            with(ball(&[])),
        ),
        (
            &["placement"],
            &[BufferId::placed_positions, BufferId::placed_normals, BufferId::placed_bounds],
            changed(ball(&["object.0.rotation=[20, 0, 0]"]), |_| ()),
            with(ball(&["object.0.position=[20, 0, 0]"])),
        ),
        (&["deform"], &[BufferId::rest, BufferId::deforms], with(twisted), with(ball(&[]))),
        (
            &["skin"],
            &[BufferId::skin_vertices, BufferId::skin_joints, BufferId::skin_matrices, BufferId::skinned],
            turned(),
            with(ball(&[])),
        ),
    ]
}

/// Of pictures.
fn pictures() -> Vec<Feature> {
    vec![
        (&["reflect"], &[], reflects(Reflection::Phong { shininess: 9 }), reflects(Reflection::None)),
        (&["opaque_faces"], &[], with(on_a_table("faces")), alone(on_a_table("faces"))),
        (&["shade_opaque"], &[], with(on_a_table("pixels")), alone(on_a_table("pixels"))),
        (
            &["pixel_shadow"],
            &[BufferId::pixel_lights, BufferId::pixel_lit],
            reflects(Reflection::Phong { shininess: 9 }),
            reflects(Reflection::None),
        ),
        (&[], &[BufferId::estimate], options(Options { estimate: true, ..Options::default() }), with(ball(&[]))),
        (
            &["pixel_receivers"],
            &[BufferId::seen],
            changed(ball(&[]), |scene| scene.transport.receivers = Receivers::Pixels),
            with(ball(&[])),
        ),
        (&["average"], &[], with(ball(&[])), changed(ball(&[]), |scene| scene.transport.receivers = Receivers::Pixels)),
        (&["visibility", "shade"], &[BufferId::hits, BufferId::radiance], with(ball(&[])), unseen(&[])),
        (&["widen"], &[BufferId::wide_boxes], unseen(&[]), unseen(&["light.0.shadows=false"])),
        (&["accumulate"], &[BufferId::mean], changed(ball(&[]), |scene| scene.camera.samples = 3), with(ball(&[]))),
        (&["tone"], &[BufferId::shown, BufferId::tones], with(ball(&[])), unseen(&[])),
    ]
}

/// Of lists of links.
fn lists() -> Vec<Feature> {
    vec![
        (&["irradiance_ratio"], &[], options(Options { mode: Mode::Render, ..Options::default() }), with(ball(&[]))),
        (
            &["pull", "coarse_solve", "acceptance_radii", "link", "gather", "push"],
            &[BufferId::moments, BufferId::emitters, BufferId::entries, BufferId::expansions, BufferId::runs],
            with(ball(&[])),
            links(),
        ),
        (
            &["reach", "mean_irradiance", "refine", "form_factor", "sum_links", "push_links"],
            &[BufferId::links, BufferId::factors, BufferId::spans, BufferId::gathered, BufferId::cluster_irradiance],
            links(),
            with(ball(&[])),
        ),
        (
            &[
                "mark_stale",
                "mark_moved",
                "mark_relit",
                "update_links",
                "update_form_factors",
                "resum_links",
                "snapshot",
            ],
            &[
                BufferId::kept_clusters,
                BufferId::change_flags,
                BufferId::edits,
                BufferId::stale,
                BufferId::stale_counts,
            ],
            incremental(Mode::Incremental),
            incremental(Mode::Render),
        ),
    ]
}

/// Of transport without lists, and without any light to carry.
fn transports() -> Vec<Feature> {
    vec![
        (&["brute"], &[], carried(ShadingMethod::Brute), with(ball(&[]))),
        (
            &["entry_sums", "clearance", "random_walk", "exit_radiosity"],
            &[
                BufferId::walk_params,
                BufferId::entry_sums,
                BufferId::entry_blocks,
                BufferId::clearance,
                BufferId::photons,
                BufferId::balances,
                BufferId::exits,
                BufferId::walk_noise,
            ],
            carried(ShadingMethod::Walk),
            with(ball(&[])),
        ),
        (
            &["deposit", "near_layers", "boundary_integrals", "krylov_step", "krylov_sum"],
            &[
                BufferId::deposits,
                BufferId::layer_places,
                BufferId::layer_firsts,
                BufferId::layer_squares,
                BufferId::layer_products,
                BufferId::krylov,
                BufferId::small_system,
                BufferId::solution,
            ],
            carried(ShadingMethod::Diffusion),
            with(ball(&[])),
        ),
        (&["gather", "push"], &[], with(ball(&[])), carried(ShadingMethod::Diffusion)),
        (&["pull", "gather", "push"], &[BufferId::moments], with(ball(&[])), carried(ShadingMethod::Octree)),
        (&["irradiance"], &[BufferId::lit], with(ball(&[])), changed(ball(&[]), |scene| scene.lights.clear())),
    ]
}

/// Of local shading.
fn shading() -> Vec<Feature> {
    vec![
        (
            &["bake_irradiance", "blur", "texture_blur"],
            &[
                BufferId::texel_hits,
                BufferId::gaussians,
                BufferId::irradiance_maps,
                BufferId::stretch,
                BufferId::blurred_rows,
            ],
            blurred(ShadingMethod::TextureBlur),
            blurred(ShadingMethod::Lambert),
        ),
        (&["curvature", "cdrf"], &[BufferId::curvature], carried(ShadingMethod::Cdrf), carried(ShadingMethod::Lambert)),
        (
            &["curvature_sums", "smooth_curvature"],
            &[BufferId::curvature_sums, BufferId::smooth_kappa],
            carried(ShadingMethod::Cdrf),
            (ball(&["object.0.material.curvature_radius=0"]), carried(ShadingMethod::Cdrf).1),
        ),
        (&["pack_normals"], &[BufferId::packed_normals], carried(ShadingMethod::Lambert), with(ball(&[]))),
        (&["cdrf_table", "cdrf_cells"], &[BufferId::cdrf_grid, BufferId::cdrf_cells], local("table"), local("closed")),
        (&["lambert"], &[], carried(ShadingMethod::Lambert), with(ball(&[]))),
        (
            &["irradiance"],
            &[BufferId::irradiance],
            changed(ball(&[]), |scene| scene.lights.push(Light::point(glam::DVec3::new(0.0, 40.0, 0.0), [9.0; 3]))),
            carried(ShadingMethod::Lambert),
        ),
    ]
}

/// The fixture of lists that a second walk writes has such lists, and others that need no second walk.
#[test]
fn some_lists_are_longer_than_what_is_kept() {
    let sets = ["object.0.detail=4", "object.0.size=40", "transport.tolerance=1e-5"];
    let scene = Scene::load_with("sphere", &sets.map(String::from)).unwrap();
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let lengths = session.state().runs().map(|run| run.expanded + run.direct + run.area + run.edge);
    let (long, short): (Vec<_>, Vec<_>) = lengths.partition(|&length| length as usize >= LINK_KEPT);
    assert!(!long.is_empty(), "{short:?}");
    let scene = Scene::load_with("sphere", &["object.0.detail=2".into()]).unwrap();
    let mut session = Session::new(&scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let length = |run: &Runs| run.expanded + run.direct + run.area + run.edge;
    assert!(session.state().runs().all(|run| (length(run) as usize) < LINK_KEPT));
}
