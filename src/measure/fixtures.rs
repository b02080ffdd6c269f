//! What conformance runs on: the smallest and ugliest meshes, and one large enough to overflow and to be cut up.

use glam::DVec3;

use crate::error::{Input, Result};
use crate::layout::{Cursor, Frame, Query};
use crate::render::plan::{Change, Mode, Options, Transport};
use crate::render::room::size;
use crate::render::run::{Room, Session};
use crate::render::stages::{stage, steps};
use crate::scene::Mesh;
use crate::scene::Scene;
use crate::state::{Scheme, State, Step};

/// A state before its first stage, and the steps to run on it.
pub struct Fixture {
    /// Its name, as `--only` takes it.
    pub name: String,
    /// The state.
    pub state: State,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

impl Fixture {
    /// All stages of a picture of this scene.
    pub fn of_scene(name: &str, scene: &Scene) -> Result<Self> {
        Self::new(name, scene, Options::default(), Room::default())
    }

    /// The stages that these options ask for, with room found by running the reference once.
    fn new(name: &str, scene: &Scene, options: Options, room: Room) -> Result<Self> {
        let mut session = Session::new(scene, None, options, room)?;
        session.frame(Change::EVERYTHING)?;
        let mut state = session.prepared.state.clone();
        let steps = session.plan.steps(&state, Change::EVERYTHING);
        size(&mut state, &session.plan);
        state.data.hits = bytemuck::zeroed_vec(state.data.hits.len());
        state.data.radiance = bytemuck::zeroed_vec(state.data.radiance.len());
        Ok(Self { name: name.to_string(), state, steps })
    }
}

/// A mesh from plain numbers.
fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Mesh {
    Mesh {
        positions: positions.iter().map(|&p| DVec3::from_array(p)).collect(),
        triangles: triangles.to_vec(),
        input_face: (0..triangles.len() as u32).collect(),
        open_edges: 0,
    }
}

/// A bent strip of `count` triangles, of uneven sizes.
fn strip(count: usize) -> Mesh {
    let vertex = |i: usize| {
        let t = i as f64 / 2.0;
        [0.4 * t + 0.1 * (i % 3) as f64, (i % 2) as f64, (0.3 * t).sin()]
    };
    let positions: Vec<_> = (0..count + 2).map(vertex).collect();
    let triangle = |i: usize| {
        let (a, b, c) = (i as u32, i as u32 + 1, i as u32 + 2);
        if i.is_multiple_of(2) { [a, c, b] } else { [a, b, c] }
    };
    let triangles: Vec<_> = (0..count).map(triangle).collect();
    mesh(&positions, &triangles)
}

/// The small scene that every fixture varies.
fn small(name: &str, sets: &[&str]) -> Result<Scene> {
    let mut all = vec!["camera.size=[48, 40]".to_string()];
    all.extend(sets.iter().map(|set| set.to_string()));
    Scene::load(name, &all)
}

/// A scene with a mesh of its own.
fn with_mesh(mesh: Mesh, sets: &[&str]) -> Result<Scene> {
    let mut all = vec![
        "camera.position=[4.0, 3.0, 9.0]",
        "camera.target=[1.0, 0.5, 0.0]",
        "light.0.direction=[0.3, 0.4, 0.8]",
        "object.0.detail=0",
    ];
    all.extend(sets);
    let mut scene = small("sphere", &all)?;
    scene.object.mesh = mesh;
    Ok(scene)
}

/// Sets the scheme as published.
const LINKS: &str = "transport.scheme=links";

/// A fixture from its name.
type Maker = fn(&str) -> Result<Fixture>;

/// Makes a scene.
type Source = fn() -> Result<Scene>;

/// Scenes that both schemes run on.
const SCENES: &[(&str, Source)] = &[
    ("one triangle (one node)", || {
        let one = mesh(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.3]], &[[0, 1, 2]]);
        with_mesh(one, &[])
    }),
    ("strip of 33 triangles (65 nodes)", || with_mesh(strip(33), &[])),
    ("sliver", || {
        let corners = [[0.0; 3], [3.0, 0.0, 0.0], [1.0, 3e-4, 0.0], [1.0, -2.0, 0.5], [1.2, 0.1, 2.0]];
        let sliver = mesh(&corners, &[[0, 1, 2], [0, 3, 1], [1, 4, 2], [2, 4, 0]]);
        with_mesh(sliver, &[])
    }),
    ("triangle that vanishes in f32", || {
        let corners = [
            [0.0; 3],
            [3.0, 0.0, 0.0],
            [1.0, 2.0, 0.0],
            [2.9, 1.9, 1.0],
            [2.9 + 1e-9, 1.9, 1.0],
            [2.9, 1.9 + 1e-9, 1.0],
        ];
        with_mesh(mesh(&corners, &[[0, 1, 2], [3, 4, 5], [3, 5, 4]]), &[])
    }),
    ("sphere with holes", || {
        let mut holed = small("sphere", &["object.0.detail=3"])?;
        holed.object.mesh.triangles.retain(|t| !t.contains(&7) && !t.contains(&30));
        Ok(holed)
    }),
    ("stiff sphere", || small("sphere", &["object.0.detail=3", "object.0.size=200"])),
    ("thin sphere", || small("sphere", &["object.0.detail=3", "object.0.size=0.5"])),
    ("no absorption", || small("sphere", &["object.0.detail=3", "object.0.material.preset=spectralon"])),
    ("candle in a bowl", || small("lotus", &["object.0.detail=32"])),
];

/// Every other fixture: its name, and how it is made.
const FIXTURES: &[(&str, Maker)] = &[
    ("dark", |name| {
        // No light at all, yet every stage runs.
        let mut fixture = varied(name, "sphere", &["object.0.detail=2"])?;
        fixture.state.data.lights.clear();
        fixture.state.data.frame[0].lights = 0;
        Ok(fixture)
    }),
    ("moments of order 0", |name| varied(name, "sphere", &["object.0.detail=3", "transport.order=0"])),
    ("moments of order 1", |name| varied(name, "sphere", &["object.0.detail=3", "transport.order=1"])),
    ("lights of two colours", |name| Fixture::of_scene(name, &two_colours()?)),
    ("lights of two colours, error estimate", |name| estimated(name, &two_colours()?)),
    ("sphere, error estimate", |name| {
        estimated(name, &small("sphere", &["object.0.detail=3", "object.0.size=60", "transport.tolerance=0.01"])?)
    }),
    ("moments of order 1, error estimate", |name| {
        estimated(name, &small("sphere", &["object.0.detail=3", "transport.order=1", "transport.tolerance=1e-4"])?)
    }),
    ("slab, error estimate", |name| estimated(name, &small("slab", &["object.0.detail=12"])?)),
    ("entries that overflow", |name| half_the_room(name, "", |frame, need| frame.entry_room = need.need_entries / 2)),
    ("links that overflow", |name| half_the_room(name, LINKS, |frame, need| frame.link_room = need.need_links / 2)),
    ("hand-downs that overflow", |name| {
        half_the_room(name, LINKS, |frame, need| frame.hand_room = need.need_hands / 2)
    }),
    ("slab, displaced sources", |name| varied(name, "slab", &["object.0.detail=12", "transport.distance=table1"])),
    ("slab, median tree", |name| varied(name, "slab", &["object.0.detail=12", LINKS, "transport.hierarchy=median"])),
    ("slab, face clusters", |name| varied(name, "slab", &["object.0.detail=12", "transport.hierarchy=face-clusters"])),
    ("stiff sphere, point samples", |name| {
        varied(name, "sphere", &["object.0.detail=3", "object.0.size=200", "transport.near=point-sampling"])
    }),
    ("thin slab, point samples, displaced sources", |name| {
        let sets = ["object.0.detail=6", "transport.near=point-sampling", "transport.distance=table1"];
        varied(name, "slab", &sets)
    }),
    ("sphere, brute force", |name| {
        let options = Options { transport: Transport::Brute, ..Options::default() };
        Fixture::new(name, &small("sphere", &["object.0.detail=2", "object.0.size=60"])?, options, Room::default())
    }),
    ("sphere in batches", |name| chunks(name, "", Mode::OnTheFly)),
    ("sphere in batches, kept", |name| chunks(name, "", Mode::Render)),
    ("sphere in chunks", |name| chunks(name, LINKS, Mode::OnTheFly)),
    ("sphere in chunks, kept", |name| chunks(name, LINKS, Mode::Render)),
    ("single form factors", |name| Ok(queries(name))),
    ("slab of 100,000 faces", |name| large(name, &["transport.tolerance=0.1"])),
    ("slab of 100,000 faces, links", |name| {
        large(name, &["transport.receiver_angle=0.5", "transport.emitter_angle=0.5"])
    }),
];

/// The fixtures whose name contains `only`.
pub fn fixtures(only: &str) -> Result<Vec<Fixture>> {
    let mut made = Vec::new();
    let mut names = Vec::new();
    for (name, scene) in SCENES {
        for scheme in [Scheme::Blocks, Scheme::Links] {
            let name = if scheme == Scheme::Links { format!("{name}, links") } else { name.to_string() };
            if name.contains(only) {
                let mut scene = scene()?;
                scene.transport.scheme = scheme;
                made.push(Fixture::of_scene(&name, &scene)?);
            }
            names.push(name);
        }
    }
    for (name, make) in FIXTURES {
        if name.contains(only) {
            made.push(make(name)?);
        }
        names.push(name.to_string());
    }
    if made.is_empty() {
        return Err(Input::new("no fixture has this in its name").found(only).expected(names.join("; ")).into());
    }
    Ok(made)
}

/// A built-in scene with these settings.
fn varied(name: &str, scene: &str, sets: &[&str]) -> Result<Fixture> {
    Fixture::of_scene(name, &small(scene, sets)?)
}

/// Two lights whose colours differ: two groups of channels, and a black one.
fn two_colours() -> Result<Scene> {
    let mut scene = small("sphere", &["object.0.detail=3", "light.0.irradiance=[3.0, 1.0, 0.0]"])?;
    let (position, intensity) = (DVec3::new(3.0, 30.0, 4.0), [90.0, 700.0, 0.0]);
    scene.lights.push(crate::scene::Light::point(position, intensity));
    Ok(scene)
}

/// With an error estimate.
fn estimated(name: &str, scene: &Scene) -> Result<Fixture> {
    Fixture::new(name, scene, Options { estimate: true, ..Options::default() }, Room::default())
}

/// A list that does not fit: both sides must say so, and leave the same behind.
fn half_the_room(name: &str, scheme: &str, halve: fn(&mut Frame, &Cursor)) -> Result<Fixture> {
    let sets: Vec<&str> = ["object.0.detail=2", scheme].into_iter().filter(|set| !set.is_empty()).collect();
    let scene = small("sphere", &sets)?;
    let mut session = Session::new(&scene, None, Options::default(), Room::default())?;
    session.frame(Change::EVERYTHING)?;
    let mut fixture = Fixture::of_scene(name, &scene)?;
    halve(&mut fixture.state.data.frame[0], &session.state().data.cursor[0]);
    Ok(fixture)
}

/// Many small chunks.
fn chunks(name: &str, scheme: &str, mode: Mode) -> Result<Fixture> {
    let room = Room { chunk_faces: 200, links: 40, batch_blocks: 30, ..Room::default() };
    let sets: Vec<&str> = ["object.0.detail=3", scheme].into_iter().filter(|set| !set.is_empty()).collect();
    Fixture::new(name, &small("sphere", &sets)?, Options { mode, ..Options::default() }, room)
}

/// More than 100,000 faces: lists overflow their first room and bindings are split.
fn large(name: &str, method: &[&str]) -> Result<Fixture> {
    let scene = small("slab", &[&["object.0.detail=224"], method].concat())?;
    let room = Room { chunk_faces: 1 << 16, links: 4, binding: 12 << 20, ..Room::default() };
    Fixture::new(name, &scene, Options::default(), room)
}

/// Form factors to evaluate one by one: inside, outside, far, above, thin, very far, and without area.
fn queries(name: &str) -> Fixture {
    let mut state = State::default();
    let (medium, nowhere) =
        (Query { strength: 0.07, z_real: 0.3, z_virtual: 1.1, ..Query::default() }, [1.0, 2.0, 3.0]);
    let (a, b, c) = ([9e5, 0.0, 5e5], [9e5, 1.0, 5e5], [9e5, 0.3, 5e5 + 1.0]);
    state.data.queries = vec![Query { a, b, c, ..medium }, Query { a: nowhere, b: nowhere, c: nowhere, ..medium }];
    for (i, (offset, height)) in [(0.1, 0.2), (1.5, 0.0), (6.0, 1.0), (0.3, 2.0), (0.9, 0.01)].into_iter().enumerate() {
        for (thin, sigma) in [(1.0, 0.0), (0.05, 0.5), (1.0, 3.0)] {
            let shift = [-offset, -0.3 * thin, -height];
            let corner = |x: f32, y: f32| [x + shift[0], y * thin + shift[1], shift[2]];
            state.data.queries.push(Query {
                a: corner(0.0, 0.0),
                b: corner(1.0 + 0.1 * i as f32, 0.1),
                c: corner(0.3, 1.0),
                strength: 0.07,
                sigma,
                z_real: 0.3,
                z_virtual: 1.1,
            });
        }
    }
    state.data.answers = bytemuck::zeroed_vec(state.data.queries.len());
    let stages: Vec<_> = stage("evaluate").into_iter().collect();
    let steps = steps(&stages, &state.schedule, state.groups.len());
    Fixture { name: name.to_string(), state, steps }
}

/// Whether a plan of any fixture runs this stage; every stage must have one.
pub fn covered(list: &[Fixture], name: &str) -> bool {
    list.iter().any(|fixture| fixture.steps.iter().any(|step| step.stage.name == name))
}
