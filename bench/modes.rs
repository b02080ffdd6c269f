//! `cargo bench --bench modes`: what each mode costs after each change, against a frame from scratch of the same scheme, with
//! the links and form factors that it made and the error beside the time, in one run on the default device.
//!
//! `cargo bench --bench modes -- bunny.obj lotus` takes other scenes.

use milkglass::error::Result;
use milkglass::gpu::Device;
use milkglass::layout::Slot;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::render::plan::{Change, Goal, Mode, Options};
use milkglass::render::run::{Room, Session};
use milkglass::scene::Scene;

const FRAMES: usize = 7;

/// A change of the scene: its name, and what frames run after it. That the same light is sent again makes no difference.
const CHANGES: [(&str, Change); 3] =
    [("shape", Change::EVERYTHING), ("light", Change::LIGHT), ("nothing", Change::RESUM)];

/// Median time of a frame after this change, milliseconds, and whether it made lists and form factors.
fn time(session: &mut Session, change: Change) -> Result<(f64, bool)> {
    let (mut times, mut links) = (Vec::new(), false);
    for _ in 0..FRAMES {
        let parts = session.frame(change)?;
        links |= parts.iter().any(|part| part.name == "link" || part.name == "refine");
        times.push(parts.iter().map(|part| part.milliseconds).sum::<f64>());
    }
    times.sort_by(f64::total_cmp);
    Ok((times[times.len() / 2], links))
}

/// Entries of all lists of a session that keeps them.
fn links(session: &mut Session) -> Result<u64> {
    session.fetch(&[Slot::runs, Slot::spans])?;
    let (state, data) = (session.state(), &session.state().data);
    let entries = state.runs().map(|run| u64::from(run.expanded + run.direct + run.area + run.edge));
    Ok(entries.sum::<u64>() + data.spans.iter().map(|span| u64::from(span.links)).sum::<u64>())
}

fn run() -> Result<()> {
    let Some(device) = Device::first()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    let mut names: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    if names.is_empty() {
        names = vec!["sphere".into(), "lotus".into()];
    }
    println!("| scene | scheme | mode | change | time | of scratch | links made | L2 |");
    println!("|---|---|---|---|---:|---:|---:|---:|");
    for name in &names {
        for scheme in ["blocks", "links"] {
            let scene = Scene::load(name, &[format!("transport.scheme={scheme}")])?;
            let mut scratch = 0.0;
            for (called, mode) in [("on-the-fly", Mode::OnTheFly), ("render", Mode::Render)] {
                let options = Options { mode, goal: Goal::Radiosity, ..Options::default() };
                let mut session = Session::new(&scene, Some(&device), options, Room::default())?;
                session.frame(Change::EVERYTHING)?;
                // On-the-fly lists are scratch, overwritten batch by batch; those of mode `keep` are the same.
                let kept = Options { mode: mode.kept(), ..options };
                let mut counted = Session::new(&scene, Some(&device), kept, Room::default())?;
                counted.frame(Change::EVERYTHING)?;
                let all = links(&mut counted)?;
                drop(counted);
                for (change, what) in CHANGES {
                    let (ms, made) = time(&mut session, what)?;
                    scratch = if scratch == 0.0 { ms } else { scratch };
                    let error = worst(&verify(&mut session, 1000, 1)?).l2;
                    let (made, share) = (if made { all } else { 0 }, ms / scratch);
                    println!(
                        "| {} | {scheme} | {called} | {change} | {ms:.1} ms | {share:.2} | {made} | {error:.1e} |",
                        scene.name
                    );
                }
            }
        }
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
