//! Near clusters over their projection (section 5.1.1 of Mertens et al. 2003), against one sample a cluster.

use crate::shell::{folder, good};
use glam::DVec3;
use milkglass::internals::dipole::form_factor::Distance;
use milkglass::internals::dipole::form_factor::edge::edge_form;
use milkglass::internals::dipole::form_factor::gauss::legendre;
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::layout::NONE;
use milkglass::internals::pipeline::plan::{Change, Mode, Options};
use milkglass::internals::session::run::Session;
use milkglass::internals::transport::links::form_factor::{Emitters, QuadratureRule};
use milkglass::measure::norms::{Norms, worst};
use milkglass::measure::reference::verify;
use milkglass::scene::{Near, Scene};

fn solved(name: &str, sets: &[&str]) -> Session {
    let sets: Vec<String> = ["transport.scheme=links"].iter().chain(sets).map(ToString::to_string).collect();
    let scene = Scene::load_with(name, &sets).unwrap();
    let mut session = Session::new(&scene, None, Options { mode: Mode::Keep, ..Options::default() }).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

/// Error of a ball of 320 faces at these solid angles, with clusters evaluated like this.
fn error(angles: [f64; 2], cluster: &str) -> Norms {
    let [receiver, emitter] = angles;
    let sets = [
        "object.0.detail=2".to_string(),
        format!("transport.receiver_angle={receiver}"),
        format!("transport.emitter_angle={emitter}"),
        format!("transport.cluster={cluster}"),
    ];
    worst(&verify(&mut solved("sphere", &sets.each_ref().map(String::as_str)), 320, 1).unwrap())
}

#[test]
fn projection_errs_less_than_one_sample() {
    for (angles, share) in [([0.27, 1.3], 0.58), ([0.05, 0.07], 0.77)] {
        let [sample, projected] = ["sample", "projected"].map(|cluster| error(angles, cluster));
        assert!(projected.l2 < share * sample.l2 && projected.max < sample.max, "{sample:?} {projected:?}");
    }
}

/// On a plane the polygon is the cluster itself: its form factor is the sum of its triangles'.
#[test]
fn on_a_plane_it_is_exact() {
    for distance in ["radial", "table1"] {
        let set = format!("transport.distance={distance}");
        let session = solved("slab", &["object.0.detail=8", &set]);
        let (state, data) = (session.state(), &session.state().data);
        let emitters = Emitters::new(data, state.distance, Near::Exact);
        let dipole = Dipole::of(&data.object_params[0], 1);
        let distance = if distance == "radial" { Distance::Radial } else { Distance::Table1 { clamp: true } };
        let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
        let (mut checked, rule) = (0, legendre(24));
        for (node, place) in data.topology.iter().enumerate() {
            let cluster = &data.clusters[node];
            let flat = wide(cluster.normal).length() > (1.0 - 1e-6) * f64::from(cluster.area);
            if place.face != NONE || !flat || place.skip as usize - node > 80 {
                continue;
            }
            assert!(data.borders[node][1] >= 4);
            let below = node..place.skip as usize;
            let faces: Vec<u32> = below.map(|k| data.topology[k].face).filter(|&face| face != NONE).collect();
            // Seen from a face of its own, from one beyond its border, and from off the plane.
            let size = f64::from(cluster.area).sqrt();
            let own = wide(data.clusters[data.leaves[faces[0] as usize] as usize].center);
            for x in [own, own + DVec3::new(1.3, 0.2, 0.1) * size, own + DVec3::new(0.3, -0.4, 0.9) * size] {
                let found = emitters.factor(node as u32, x, QuadratureRule::Edges)[1];
                let each = |&face: &u32| {
                    let triangle = data.triangles[face as usize].map(|v| wide(data.positions[v as usize]));
                    edge_form(&triangle, data.triangles[face as usize], x, &dipole, distance, &rule)
                };
                let sum: f64 = faces.iter().map(each).sum();
                assert!((found - sum).abs() < 2e-3 * sum + 1e-4, "node {node}: {found} for {sum}");
                checked += 1;
            }
        }
        assert!(checked > 300, "{checked}");
    }
}

#[test]
fn near_clusters_are_few_and_kept_apart() {
    let session = solved("sphere", &["object.0.detail=3"]);
    let data = &session.state().data;
    let near = |link: u32| data.topology[data.links[link as usize].emitter as usize].face == NONE;
    let edges: u32 = data.spans.iter().map(|span| span.edges).sum();
    let clusters = data.spans.iter().flat_map(|span| span.edge..span.edge + span.edges);
    let clusters = clusters.filter(|&k| near(data.edge_links[k as usize])).count();
    let links: u32 = data.spans.iter().map(|span| span.links).sum();
    assert!(clusters > 0 && clusters < edges as usize && (clusters as f64) < 0.5 * f64::from(links), "{clusters}");
    // With one sample a cluster there are neither borders nor radii.
    let data = &solved("sphere", &["object.0.detail=3", "transport.cluster=sample"]).state().data.clone();
    assert!(data.borders.is_empty() && data.border_edges.is_empty() && data.cluster_reach.is_empty());
}

#[test]
fn the_command_line_takes_both() {
    let here = folder(&[]);
    for cluster in ["sample", "projected"] {
        let set = format!("--set transport.cluster={cluster} --set object.0.detail=2");
        let plan = good(&here, &format!("plan sphere {set} --device cpu")).0;
        assert_eq!(plan.contains("border_edges"), cluster == "projected", "{plan}");
    }
}
