//! Sections on run time: per stage, per mode, and error against run time per method.

use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::pareto::{self, Lighting, METHODS, Origin, Ratio, Reach, Settings, csv, ratios, svg, sweep};
use crate::measure::table::Table;
use crate::measure::{modes as kept, profile as stages};
use crate::scene::Scene;

/// Measures all methods at all settings, in one run per scene.
pub fn pareto(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let names: &[&str] = bench.either(&["sphere"], &["sphere", "lotus"]);
    for name in names {
        let sets: &[String] = if bench.quick { &["object.0.detail=3".into()] } else { &[] };
        swept(bench, page, &Scene::load_with(name, sets)?)?;
    }
    Ok(())
}

fn swept(bench: &Bench<'_>, page: &mut Page, scene: &Scene) -> Result<()> {
    let settings = Settings {
        methods: METHODS.iter().collect(),
        values: bench.either(3, usize::MAX),
        repeat: bench.either(3, 5),
        samples: bench.either(100, 500),
        seed: 1,
        budget: bench.either(3.0, 10.0),
        truth: None,
    };
    let found = sweep(&pareto::Bench { scene, device: bench.device }, &settings)?;
    let origin = Origin::new(scene, bench.device, settings.repeat);
    page.head(&format!("{}, {} triangles", origin.scene, origin.faces));
    page.say(
        "Down and to the left is better. When the light moves, everything that depends on light is computed again; \
         when it rests, only the sums are. Errors are L2 of the radiosity, worst channel, against brute force in f64 \
         over the method's own leaf sums, and against the area integral. All points were measured in one run on one \
         device.",
    );
    let plot = svg(&found, &origin)?;
    if page.front.is_empty() {
        page.to_front(|page| {
            page.plot(&plot, true);
            page.say("Error against run time: down and to the left is better. Section pareto explains it.");
        });
    }
    page.plot(&plot, true);
    page.file(&format!("pareto-{}.csv", origin.scene), csv(&found, &origin)?.into_bytes());

    let all = ratios(&found, &METHODS[0]);
    page.say(&format!("Wall time at equal error, and its ratio to that of {} (above 1: slower):", METHODS[0].name));
    page.table(&format!("pareto-{}-ratios", origin.scene), &Ratio::table(&all))?;

    for lighting in Lighting::ALL {
        for method in found.methods().into_iter().skip(1) {
            let own = all.iter().filter(|ratio| ratio.lighting == lighting && ratio.method.name == method.name);
            if let Some((times, words)) = own.filter_map(compared).min_by(|a, b| a.0.total_cmp(&b.0)) {
                let (scene, light, ours) = (&origin.scene, lighting.name(), METHODS[0].name);
                let aim = format!("{scene}, {light}: {ours} faster than {} at equal error", method.name);
                page.find(Tone::of(times >= 1.0), &aim, &words);
            }
        }
    }
    Ok(())
}

/// A method's time over the base's, at the finest error at which both are known, and both times in words.
fn compared(ratio: &Ratio) -> Option<(f64, String)> {
    // Without a setting, the time at any error that is met is exact.
    let theirs = |reach: Reach| match reach {
        Reach::Within(time) if ratio.method.parameter.is_empty() => Reach::At(time),
        other => other,
    };
    (0..3).rev().find_map(|k| {
        // An upper bound on a time decides if it is the shorter of the two, or if both are bounds.
        let (a, b, bound) = match (theirs(ratio.times[k]), ratio.base[k]) {
            (Reach::At(a), Reach::At(b)) => (a, b, ""),
            (Reach::At(a), Reach::Within(b)) if b <= a => (a, b, ""),
            (Reach::Within(a), Reach::At(b)) if a <= b => (a, b, ""),
            (Reach::Within(a), Reach::Within(b)) => (a, b, " by the coarsest setting of either"),
            _ => return None,
        };
        let (error, target) = (ratio.error(), ["1e-2", "1e-3", "1e-4"][k]);
        let (ours, name) = (METHODS[0].name, ratio.method.name);
        Some((a / b, format!("{error} {target}: {ours} {b:.1} ms, {name} {a:.1} ms{bound}")))
    })
}

/// Time, operations and memory traffic of each stage.
pub fn profile(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say(
        "The time of each stage, and what bounds it. The kernels themselves count their work in one more frame of the \
         same result; the device's own rates are measured in the same run. A stage with one share near 100 % is bound by \
         that resource, one without any large share waits.",
    );
    for name in bench.either(&["sphere"][..], &["sphere", "lotus", "fish", "bust"]) {
        let settings =
            stages::Settings { frames: bench.either(5, 11), enough: bench.either(5.0, 20.0), ..Default::default() };
        let found = stages::profile(&Scene::load_with(name, &[])?, bench.device, &settings)?;
        let (frames, wall) = (found.frames, found.wall.median);
        page.head(&format!("{name}: a frame from scratch, {wall:.2} ms by the host's clock, the median of {frames}"));
        if let Some(rates) = &found.rates {
            let (copy, fma, exp) = (rates.copy * 1e-9, rates.fma * 1e-9, rates.exp * 1e-9);
            page.say(&format!(
                "The device's rates: copy {copy:.2} GB/s (read and written), {fma:.2} G FMA/s, {exp:.2} G exp/s. Peak \
                 device memory: {:.1} MiB.",
                found.peak as f64 / 1_048_576.0
            ));
        }
        found.notes.iter().for_each(|note| page.say(note));
        page.small_table(&profiled(&found));
        if let Some(drawing) = stages::roofline(&found)? {
            page.plot(&drawing, false);
        }
        page.file(&format!("profile-{name}.csv"), found.csv()?.into_bytes());
    }
    Ok(())
}

/// The stages of a profile.
fn profiled(found: &stages::Profile) -> Table {
    let work = |row: &stages::Row, count: fn(&stages::Work) -> u64| {
        row.work.map_or_else(String::new, |work| format!("{:.3}", count(&work) as f64 * 1e-6))
    };
    let share = |row: &stages::Row, k: usize| {
        found.shares(row)[k].map_or_else(String::new, |share| format!("{:.1}", 100.0 * share))
    };
    let time = |row: &stages::Row| row.device.unwrap_or(row.wall);
    Table::of(
        &found.rows,
        &[
            ("stage", "", &|row| row.stage.clone()),
            ("ms", "median time on the device", &|row| format!("{:.3}", time(row).median)),
            ("spread", "10th to 90th percentile, ms", &|row| format!("{:.3} to {:.3}", time(row).low, time(row).high)),
            ("dispatches", "per frame", &|row| row.dispatches.to_string()),
            ("read, MB", "bytes loaded, each bound byte once at most", &|row| work(row, |work| work.read)),
            ("written, MB", "bytes stored, likewise", &|row| work(row, |work| work.written)),
            ("M flop", "millions of float additions and multiplications; a fused one counts two", &|row| {
                work(row, |work| work.flops)
            }),
            ("M div", "millions of divisions and square roots", &|row| work(row, |work| work.roots)),
            ("M exp", "millions of exponentials, logarithms and trigonometric functions", &|row| {
                work(row, |work| work.exps)
            }),
            ("copy, %", "share of the device's own copy rate", &|row| share(row, 0)),
            ("fma, %", "share of its rate of fused multiply-adds", &|row| share(row, 1)),
            ("exp, %", "share of its rate of exponentials", &|row| share(row, 2)),
        ],
    )
}

/// The cost of each mode after each change.
pub fn modes(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say(&format!(
        "The same change before every frame; the bump moves {} % of the triangles. Mertens et al. have 0.49 of a frame \
         from scratch for incremental and 0.28 for render in their table 3, at 131,736 triangles.",
        100.0 * kept::LOCAL
    ));
    let mut rows = Vec::new();
    // The full lotus of 54,720 triangles takes more than a quarter of an hour on lavapipe with two cores.
    let scenes: &[_] = bench.either(&[("sphere", "3")], &[("sphere", "5"), ("lotus", "128")]);
    for (name, detail) in scenes {
        let sets = [format!("object.0.detail={detail}")];
        let found = kept::rows(bench.device, &Scene::load_with(name, &sets)?, bench.either(3, 7), "")?;
        for row in found.iter().filter(|row| row.mode == "render" && row.change == "light") {
            let tone = Tone::of(row.ratio <= 1.0);
            let (scheme, ratio) = (row.scheme, row.ratio);
            let aim = format!("{name}, {scheme}: mode render makes a new light cheaper than a frame from scratch");
            page.find(tone, &aim, &format!("{ratio:.2} of its time (published: 0.28)"));
        }
        for (change, aim) in [("material", 0.6), ("motion", 0.4)] {
            let edited = |row: &&kept::Row| (row.scheme, row.mode, row.change) == ("blocks", "on-the-fly", change);
            for row in found.iter().filter(edited) {
                let ratio = row.wall_ratio;
                let aim =
                    (format!("{name}, blocks: an edit of kind {change} takes {aim} of a frame from scratch"), aim);
                page.find(Tone::of(ratio <= aim.1), &aim.0, &format!("{ratio:.2} of its time, with the host's part"));
            }
        }
        let time = |mode: &str| {
            let own = |row: &&kept::Row| (row.scheme, row.mode, row.change) == ("links", mode, "bump");
            found.iter().find(own).map(|row| row.milliseconds)
        };
        if let (Some(scratch), Some(kept)) = (time("on-the-fly"), time("incremental")) {
            let tone = Tone::of(kept <= 0.25 * scratch);
            let (ratio, share) = (kept / scratch, 100.0 * kept::LOCAL);
            let aim =
                format!("{name}, links, mode incremental: moving {share} % of the triangles takes 0.25 of a frame");
            page.find(tone, &aim, &format!("{ratio:.3} (published: 0.49)"));
        }
        rows.extend(found);
    }
    page.table("modes", &kept::Row::table(&rows))
}
