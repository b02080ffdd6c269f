//! Measurement: counts are correct, profiles are consistent, and a frame creates exactly what its plan lists.

use std::collections::BTreeSet;

use crate::devices::on_devices;
use milkglass::internals::gpu::count::Traffic;
use milkglass::internals::gpu::{Device, KernelKey, SingleKernel};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::frame::{STAGES, stage};
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::measure::profile::{Settings, against, profile};
use milkglass::scene::{Light, Receivers, Reflection, Scene};

static COUNT: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tests-kernels-count.spv"));

#[test]
fn kernels_count_what_they_do() {
    on_devices(|device| {
        for (elements, rounds) in [(1000u64, 10u64), (64, 1), (1, 0)] {
            let size: Vec<u8> = [elements, rounds].iter().flat_map(|&n| (n as u32).to_ne_bytes()).collect();
            let mut buffers = [size, 1f32.to_ne_bytes().repeat(elements as usize)];
            let alone = SingleKernel { name: "count", spirv: COUNT, constants: &[] };
            let tally = alone.tally(device, &mut buffers, elements).unwrap().unwrap();
            let all = elements.next_multiple_of(64);
            assert_eq!(tally.invocations, all, "{}", device.name());
            assert_eq!((tally.exps, tally.roots), (elements * rounds.div_ceil(4), elements), "{elements} x {rounds}");
            // One multiplication and one addition per round; five operations in the dot product, and the sum after it.
            assert_eq!(tally.flops, elements * (2 * rounds + 6), "{elements} x {rounds}");
            assert_eq!(tally.moved[&0], Traffic { loaded: 8 * all, stored: 0 });
            assert_eq!(tally.moved[&1], Traffic { loaded: 8 * elements, stored: 4 * elements });
        }
    });
}

fn small(name: &str, sets: &[&str]) -> Scene {
    let all = [sets, &["camera.size=[24, 20]"]].concat();
    Scene::load_with(name, &all.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap()
}

fn ball(sets: &[&str]) -> Scene {
    small("sphere", &[&["object.0.detail=2", "transport.receivers=faces"], sets].concat())
}

#[test]
fn a_profile_hangs_together() {
    on_devices(|device| {
        let scene = ball(&[]);
        let found = profile(&scene, Some(device), &Settings { frames: 3, ..Settings::default() }).unwrap();
        let rates = found.rates.expect("every driver of these tests has timestamps");
        assert!(rates.copy > 1e6 && rates.fma > 1e6 && rates.exp > 1e6, "{rates:?}");
        assert!(found.notes.is_empty() && found.peak > 100_000, "{:?}", found.notes);
        let row = |name: &str| found.rows.iter().find(|row| row.stage == name).unwrap();
        // One value of 12 bytes per face, and invocations in groups of 64.
        for name in ["irradiance", "push"] {
            let work = row(name).work.unwrap();
            assert_eq!((work.invocations, work.stored, work.written), (320, 320 * 12, 320 * 12), "{name}");
        }
        for row in &found.rows {
            let (work, time) = (row.work.unwrap(), row.device.unwrap());
            assert!(row.dispatches >= row.steps && work.invocations > 0 && work.written > 0, "{row:?}");
            assert!(work.read <= work.loaded && work.written <= work.stored, "{row:?}");
            assert!(time.low <= time.median && time.median <= time.high && time.low > 0.0 && row.wall.median > 0.0);
            assert!(row.share_of_copy(&rates).unwrap() > 0.0);
        }
        assert!(row("gather").work.unwrap().exps > 0 && row("link").work.unwrap().exps == 0);
        assert_eq!(found.trace.len(), 3);
        // Slow frames reduce the number of frames.
        let few = profile(&scene, Some(device), &Settings { frames: 9, enough: 0.0, ..Settings::default() }).unwrap();
        assert_eq!((few.frames, few.trace.len()), (3, 3));
    });
}

#[test]
fn on_the_cpu_a_profile_has_times_only() {
    let found = profile(&ball(&[]), None, &Settings { frames: 2, ..Settings::default() }).unwrap();
    assert!(found.rates.is_none() && found.on_device.is_none() && found.wall.median > 0.0);
    assert!(found.rows.iter().all(|row| row.work.is_none() && row.device.is_none() && row.wall.median >= 0.0));
    assert!(found.rows.iter().any(|row| row.stage == "gather") && found.notes.len() == 1);
}

#[test]
fn a_device_against_itself_takes_every_stage() {
    on_devices(|device| {
        let rows = against(&ball(&[]), [device, device], &Settings { frames: 3, ..Settings::default() }).unwrap();
        let names: Vec<_> = rows.iter().map(|row| row.what.as_str()).collect();
        assert!(names.contains(&"gather") && names.ends_with(&["stages", "frame"]), "{names:?}");
        assert!(rows.iter().all(|row| row.ratio > 0.0));
    });
}

/// Kernels, buffers, and dispatches per stage.
type Made = (BTreeSet<String>, BTreeSet<BufferId>, Vec<(&'static str, usize)>);

/// What frames created and dispatched on a device; checks that this is what the plan lists.
fn made(device: &Device, scene: &Scene, options: Options) -> Made {
    let mut session = Session::new(scene, Some(device), options).unwrap();
    let mut needs = Vec::new();
    // Incremental mode builds links in the first frame and updates them in the second.
    for revises in 0..1 + u32::from(options.mode == Mode::Incremental) {
        session.frame(Change::EVERYTHING).unwrap();
        let scratch = if revises == 0 { Change::RELINK } else { Change::default() };
        needs.extend(session.needs(Change::EVERYTHING.and(scratch)).unwrap());
    }
    assert!(session.device().is_some());
    let pipelines: BTreeSet<_> = session.pipelines().into_iter().collect();
    let listed: BTreeSet<_> = needs
        .iter()
        .flat_map(|need| &need.kernels)
        .map(|kernel| KernelKey { name: kernel.name.clone(), constants: kernel.constants.clone() })
        .collect();
    assert_eq!(pipelines, listed, "{}", scene.name);
    let buffers = session.device_buffers();
    assert_eq!(buffers, session.buffers(), "{}", scene.name);
    let planned: Vec<_> = session.plan().stages.iter().map(|stage| stage.name).collect();
    assert!(needs.iter().all(|need| planned.contains(&need.stage)), "{planned:?}");
    assert!(session.plan().left_out.iter().all(|(what, why)| !planned.contains(what) && !why.is_empty()));
    let dispatched = needs.iter().map(|need| (need.stage, need.dispatches)).collect();
    (
        pipelines.into_iter().map(|kernel| kernel.name).collect(),
        buffers.into_iter().map(|(slot, _)| slot).collect(),
        dispatched,
    )
}

type Case = (Scene, Options);

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

/// Stages, buffers, a frame with the feature, a frame without it.
type Feature = (&'static [&'static str], &'static [BufferId], Case, Case);

/// Each feature: the stages and buffers that only it needs, a frame with it, and the same frame without it.
fn features() -> Vec<Feature> {
    let sky = |background: bool| {
        let environment = format!("camera.background={}", if background { "environment" } else { "[0,0,0]" });
        ball(&["light.0={type='environment',radiance=1}", &environment])
    };
    let tiles =
        |on: &str| ball(&["object.0.material.texture=builtin:tiles", &format!("object.0.material.texture_on={on}")]);
    let layered = || small("slab-layers", &["object.0.detail=4"]);
    let twisted = ball(&["object.0.deform=[{type='twist',angle=30}]"]);
    let reflects =
        |reflection| changed(ball(&[]), move |scene| scene.objects[0].material.surface.reflection = reflection);
    let on_a_table =
        |receivers: &str| small("candle", &["object.0.detail=16", &format!("transport.receivers={receivers}")]);
    let alone = |scene| changed(scene, |scene| scene.objects.retain(|object| object.material.opaque.is_none()));
    let options = |options: Options| (ball(&[]), options);
    let links = || with(ball(&["transport.scheme=links"]));
    let incremental = || ball(&["transport.scheme=links", "object.0.deform=[{type='twist',angle=30}]"]);
    let blurred = |transport| {
        let scene = ball(&["transport.unwrap=true", "transport.blur_texture=32"]);
        (scene, Options { transport, ..Options::default() })
    };
    let local = |cdrf: &str| {
        let scene = ball(&[&format!("transport.cdrf={cdrf}"), "transport.cdrf_table=16"]);
        (scene, Options { transport: ShadingMethod::Cdrf, ..Options::default() })
    };
    vec![
        (&["shadow"], &[BufferId::lit, BufferId::cut_short], with(ball(&[])), with(ball(&["light.0.shadows=false"]))),
        (&["environment"], &[BufferId::sky, BufferId::harmonics], with(sky(false)), with(ball(&[]))),
        (&["backdrop"], &[], with(sky(true)), with(sky(false))),
        (&["texture_in"], &[BufferId::texels, BufferId::corner_uvs], with(tiles("entry")), with(ball(&[]))),
        (&["texture_out"], &[BufferId::texels, BufferId::corner_uvs], with(tiles("exit")), with(ball(&[]))),
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
        (&["deform"], &[BufferId::rest, BufferId::deforms], with(twisted), with(ball(&[]))),
        (&["reflect"], &[], reflects(Reflection::Phong { shininess: 9 }), reflects(Reflection::None)),
        (&["opaque_faces"], &[], with(on_a_table("faces")), alone(on_a_table("faces"))),
        (
            &["shade_opaque", "pixel_shadow"],
            &[BufferId::pixel_lit],
            with(on_a_table("pixels")),
            alone(on_a_table("pixels")),
        ),
        (&[], &[BufferId::estimate], options(Options { estimate: true, ..Options::default() }), with(ball(&[]))),
        (
            &["pixel_receivers"],
            &[BufferId::seen],
            changed(ball(&[]), |scene| scene.transport.receivers = Receivers::Pixels),
            with(ball(&[])),
        ),
        (&["average"], &[], with(ball(&[])), changed(ball(&[]), |scene| scene.transport.receivers = Receivers::Pixels)),
        (
            &["visibility", "shade"],
            &[BufferId::hits, BufferId::radiance],
            with(ball(&[])),
            options(Options { goal: Goal::Radiosity, ..Options::default() }),
        ),
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
            &["mark_moved", "mark_relit", "update_links", "update_form_factors", "resum_links", "snapshot"],
            &[
                BufferId::kept_clusters,
                BufferId::change_flags,
                BufferId::edits,
                BufferId::stale,
                BufferId::stale_counts,
            ],
            (incremental(), Options { mode: Mode::Incremental, ..Options::default() }),
            (incremental(), Options { mode: Mode::Render, ..Options::default() }),
        ),
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
        (&["brute"], &[], carried(ShadingMethod::Brute), with(ball(&[]))),
        (&["pull", "gather", "push"], &[BufferId::moments], with(ball(&[])), carried(ShadingMethod::Octree)),
        (&["irradiance"], &[BufferId::lit], with(ball(&[])), changed(ball(&[]), |scene| scene.lights.clear())),
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

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_is_turned_off_is_not_there() {
    let list = features();
    // Every stage belongs to some feature, except `refit`, which every frame runs, and the stages of `eval`.
    for stage in STAGES.iter().filter(|stage| !["refit", "evaluate", "cdrf_values"].contains(&stage.name)) {
        assert!(list.iter().any(|(stages, ..)| stages.contains(&stage.name)), "no feature has stage {}", stage.name);
    }
    on_devices(|device| {
        for (stages, slots, on, off) in &list {
            let (with, without) = (made(device, &on.0, on.1), made(device, &off.0, off.1));
            for name in *stages {
                let folder = format!("{}/{name}", stage(name).unwrap().module);
                let own = |kernels: &BTreeSet<String>| {
                    kernels
                        .iter()
                        .filter(|kernel| **kernel == folder || kernel.starts_with(&format!("{folder}/")))
                        .count()
                };
                let dispatches = |list: &[(&str, usize)]| list.iter().find(|row| row.0 == *name).map_or(0, |row| row.1);
                assert!(own(&with.0) > 0 && dispatches(&with.2) > 0, "{name} is not there");
                assert_eq!((own(&without.0), dispatches(&without.2)), (0, 0), "{name} is still there");
            }
            for slot in *slots {
                assert!(with.1.contains(slot), "{stages:?}: buffer {slot:?} is not there");
                assert!(!without.1.contains(slot), "{stages:?}: buffer {slot:?} is still there");
            }
        }
    });
}
