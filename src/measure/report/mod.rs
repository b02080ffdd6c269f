//! The report: all measurements on one page, for one device.
//!
//! A section is one entry of [`SECTIONS`] and one function that writes it. If a section fails, the page shows the
//! error and the other sections still run.

mod accuracy;
mod checks;
mod compile;
mod day;
mod francois;
mod history;
mod html;
mod kubo;
mod mertens;
mod pictures;
mod setting;
mod speed;
mod truth;
mod unfinished;
mod vary;
mod whole;

use std::time::Instant;

pub use checks::stress_table;
pub use day::Day;
pub use html::{Finding, Page, Shown, Tone, escape};
pub use pictures::png;
pub use unfinished::{UNFINISHED, measured};
pub use whole::{Written, whole};

use crate::error::Result;
use crate::gpu::Device;
use crate::measure::folder::REPORT;
use crate::measure::profile::file::Subject;
use crate::measure::profile::history::Entry;
use crate::measure::rounds::Samples;
use crate::measure::table::Table;
use crate::scene::Scene;

/// Keeps the bytes of a file of this name.
pub type Keep<'a> = dyn Fn(&str, &[u8]) -> Result<()> + 'a;

/// Compiles a scene's kernels for GPUs of these families: a heading and a table for each.
pub type Compilers<'a> = dyn Fn(&Scene, &[&str]) -> Result<Vec<(String, Table)>> + 'a;

/// Times frames of a profile's subject on a device, the CPU if there is none.
pub type Timed<'a> = dyn Fn(&Subject, Option<&Device>) -> Result<Samples> + 'a;

/// Settings of a report.
#[derive(Clone, Copy, Default)]
pub struct Bench<'a> {
    /// The device; `None` for the CPU.
    pub device: Option<&'a Device>,
    /// Small scenes and few settings; takes minutes.
    pub quick: bool,
    /// Mesh files that tables 4 and 5 of Mertens et al. and figure 2 of Kubo et al. are measured for, too.
    pub meshes: &'a [String],
    /// Runs of `profile --history`.
    pub history: Option<&'a [Entry]>,
    /// What was found on another device.
    pub day: Option<&'a Day>,
    /// Times what a profile timed on a device, where the caller can.
    pub timed: Option<&'a Timed<'a>>,
    /// Has compilers of other GPUs compile the kernels of a scene, where the caller can.
    pub compilers: Option<&'a Compilers<'a>>,
    /// Keeps a file, by its name, as soon as it is there: what was measured stays if the run is stopped.
    pub keep: Option<&'a Keep<'a>>,
}

impl Bench<'_> {
    /// Chooses between the values for a quick and for a full report.
    fn either<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Keeps a file that is whole but may grow.
    fn keep(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.keep.map_or(Ok(()), |keep| keep(name, bytes))
    }
}

/// A section.
pub struct Section {
    /// Its name, as `--only` takes it.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Measures and writes the section.
    pub write: fn(&Bench<'_>, &mut Page) -> Result<()>,
}

/// All sections, in the order of the page.
pub static SECTIONS: &[Section] = &[
    Section { name: "devices", title: "Devices", write: setting::devices },
    Section { name: "plan", title: "Plan: what each scene needs", write: setting::plans },
    Section { name: "profile", title: "Profile: time and work of each stage", write: speed::profile },
    Section { name: "history", title: "History: times of stages over many runs", write: history::history },
    Section { name: "day", title: "Another device, and this one", write: day::day },
    Section { name: "compile", title: "What compilers of other GPUs make of the kernels", write: compile::compile },
    Section { name: "vary", title: "Varying the API: what other choices of Vulkan cost", write: vary::vary },
    Section {
        name: "conform",
        title: "Conformance: does the device compute what the CPU does?",
        write: checks::conform,
    },
    Section { name: "stress", title: "Extreme cases", write: checks::stress },
    Section { name: "pareto", title: "Error against run time", write: speed::pareto },
    Section { name: "modes", title: "What is kept from frame to frame", write: speed::modes },
    Section { name: "mertens", title: "Hierarchical dipole: Mertens et al. 2003", write: mertens::mertens },
    Section { name: "kubo", title: "Shading by curvature: Kubo et al. 2010", write: kubo::kubo },
    Section { name: "layers", title: "Layers beneath the surface: Francois et al. 2006", write: francois::francois },
    Section { name: "accuracy", title: "Numerical error beside the error of the model", write: accuracy::accuracy },
    Section { name: "truth", title: "How true: every method against a random walk", write: truth::truth },
    Section { name: "pictures", title: "Built-in scenes", write: pictures::scenes },
];

/// Tables and figures that are parts of sections, each by its own name, for `--only`.
pub static PARTS: &[Section] = &[
    Section { name: "mertens/figure3", title: "Mertens et al. 2003, figure 3", write: mertens::figure3 },
    Section { name: "mertens/figure4", title: "Mertens et al. 2003, figure 4", write: mertens::figure4 },
    Section { name: "mertens/table3", title: "Mertens et al. 2003, table 3", write: mertens::table3 },
    Section { name: "mertens/table4", title: "Mertens et al. 2003, table 4", write: mertens::table4 },
    Section { name: "mertens/table5", title: "Mertens et al. 2003, table 5 and figure 5", write: mertens::table5 },
    Section { name: "kubo/figure2", title: "Kubo et al. 2010, figure 2", write: kubo::figure2 },
    Section { name: "kubo/table1", title: "Kubo et al. 2010, table 1", write: kubo::table },
    Section { name: "layers/table2", title: "Francois et al. 2006, table 2", write: francois::table2 },
    Section { name: "layers/figure14", title: "Francois et al. 2006, figure 14", write: francois::pictures },
];

/// A finished report.
pub struct Report {
    /// The HTML page.
    pub page: String,
    /// Name and bytes of each file beside it that was measured now.
    pub files: Vec<(String, Vec<u8>)>,
    /// Failed checks and sections.
    pub faults: Vec<String>,
}

/// Writes these sections, but those that were measured `earlier`; `tell` receives the name of each before it starts.
/// After each its files are kept, then the page so far, then what another run needs to go on; an error means that a
/// file could not be kept.
pub fn report(
    bench: &Bench<'_>,
    sections: &[&Section],
    mut earlier: Vec<Written>,
    tell: &mut dyn FnMut(&str),
) -> Result<Report> {
    let about = setting::about(bench);
    let so_far = |written: &[Written]| whole("milkglass report", &about, written, sections.len());
    let mut written = Vec::new();
    // Before anything is measured: a mesh that changes while the report runs is another one.
    let subject = unfinished::subject(bench, sections);
    for section in sections {
        if let Some(at) = earlier.iter().position(|known| known.name == section.name) {
            written.push(earlier.swap_remove(at));
            continue;
        }
        tell(section.name);
        let (start, mut page) = (Instant::now(), Page::default());
        if let Err(error) = (section.write)(bench, &mut page) {
            page.fail(&error.to_string());
        }
        for message in bench.device.map(Device::take_messages).unwrap_or_default() {
            page.fail(&format!("the validation layer says: {message}"));
        }
        let seconds = start.elapsed().as_secs_f64();
        page.files.iter().try_for_each(|(name, bytes)| bench.keep(name, bytes))?;
        written.push(Written { name: section.name.into(), title: section.title.into(), page, seconds });
        bench.keep(REPORT.page, so_far(&written).as_bytes())?;
        bench.keep(UNFINISHED, &unfinished::bytes(&subject, &written))?;
    }
    let page = so_far(&written);
    let (mut files, mut faults) = (Vec::new(), Vec::new());
    for Written { name, page, .. } in written {
        files.extend(page.files);
        faults.extend(page.faults.into_iter().map(|fault| format!("{name}: {fault}")));
    }
    Ok(Report { page, files, faults })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::measure::table::{Column, Table};

    #[test]
    fn what_fails_is_shown_and_the_rest_goes_on() {
        let good = |_: &Bench<'_>, page: &mut Page| {
            page.find(Tone::Loss, "as fast as <that>", "1.2 of its time");
            page.tile(Tone::Note, "3 < 4", "a tile");
            page.to_front(|page| page.say("in front"));
            let columns: [Column<'_, f64>; 2] =
                [("what", "", &|_| "a, b".into()), ("mm", "its <size>", &f64::to_string)];
            page.table("sizes", &Table::of(&[1.5], &columns))
        };
        let bad = |_: &Bench<'_>, page: &mut Page| {
            page.say("so far so good");
            Err(Error::Check("it broke".into()))
        };
        let sections =
            [Section { name: "bad", title: "Bad", write: bad }, Section { name: "good", title: "Good", write: good }];
        let mut told = Vec::new();
        let kept = std::cell::RefCell::new(Vec::new());
        let keep = |name: &str, bytes: &[u8]| {
            kept.borrow_mut().push((name.to_string(), String::from_utf8_lossy(bytes).into_owned()));
            Ok(())
        };
        let bench = Bench { quick: true, keep: Some(&keep), ..Bench::default() };
        let made = report(&bench, &sections.each_ref(), Vec::new(), &mut |name| told.push(name.to_string())).unwrap();
        assert_eq!((told, made.faults), (vec!["bad".into(), "good".into()], vec!["bad: it broke".to_string()]));
        for words in [
            "1 check FAILS",
            "so far so good",
            "FAILS: it broke",
            "<td>as fast as &lt;that&gt;</td>",
            "<td class=\"r\">1.5",
            "<b>3 &lt; 4</b>",
            "<dt>mm</dt><dd>its &lt;size&gt;</dd>",
            "<details class=\"section\" open><summary><h2>Bad",
            "<details class=\"section\"><summary><h2>Good",
        ] {
            assert!(made.page.contains(words), "{words}");
        }
        let place = |words: &str| made.page.find(words).unwrap();
        assert!(place("FAILS: it broke") < place("in front") && place("in front") < place("as fast as"));
        assert_eq!(made.files, [("sizes.csv".to_string(), b"what,mm\n\"a, b\",1.5\n".to_vec())]);
        // A file as soon as it is there, and the page after each section.
        let names: Vec<String> = kept.borrow().iter().map(|(name, _)| name.clone()).collect();
        assert_eq!(names, ["index.html", UNFINISHED, "sizes.csv", "index.html", UNFINISHED]);
        let unfinished = "Unfinished: 1 of 2 sections";
        assert!(kept.borrow()[0].1.contains(unfinished) && !made.page.contains("Unfinished"));
        let full = |_: &str, _: &[u8]| Err(Error::Check("the disk is full".into()));
        let lost = report(&Bench { keep: Some(&full), ..bench }, &sections.each_ref(), Vec::new(), &mut |_| ());
        assert_eq!(lost.err().map(|error| error.to_string()), Some("the disk is full".into()));
    }

    #[test]
    fn the_badge_says_what_the_rows_below_it_say() {
        let missed = |_: &Bench<'_>, page: &mut Page| {
            page.find(Tone::Loss, "fast", "slow");
            page.find(Tone::Win, "right", "right");
            Ok(())
        };
        let met = |_: &Bench<'_>, page: &mut Page| {
            page.find(Tone::Win, "right", "right");
            Ok(())
        };
        let checked = |_: &Bench<'_>, page: &mut Page| {
            super::whole::verdict(page, "Sound", "2 cases");
            Ok(())
        };
        let nothing = |_: &Bench<'_>, _: &mut Page| Ok(());
        let write: [fn(&Bench<'_>, &mut Page) -> Result<()>; 4] = [missed, met, checked, nothing];
        let sections = [0, 1, 2, 3].map(|k| Section { name: "s", title: "S", write: write[k] });
        let bench = Bench { quick: true, ..Bench::default() };
        let page = |chosen: &[usize]| {
            let chosen: Vec<&Section> = chosen.iter().map(|&k| &sections[k]).collect();
            report(&bench, &chosen, Vec::new(), &mut |_| ()).unwrap().page
        };
        let passes = "very check passes";
        let found = page(&[0, 1]);
        assert!(found.contains("<b>1 of 3 aims missed</b>") && !found.contains(passes));
        assert!(found.contains("Aims: 1 missed, 2 met"));
        let found = page(&[0, 2]);
        assert!(found.contains("<b>1 of 2 aims missed</b><span>every check passes"));
        assert!(page(&[1]).contains("<b>All aims met</b><span>1 of them"));
        assert!(page(&[2]).contains("<b>Every check passes</b>"));
        assert!(!page(&[3]).contains(passes) && !page(&[3]).contains("aims"));
    }
}
