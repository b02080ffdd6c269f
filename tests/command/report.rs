//! `milkglass report` run as a program: a complete page without external references, and what is refused.

use crate::shell::{bad, folder, good, names, read, said};
use milkglass::measure::report::SECTIONS;

/// Tags without an end tag.
const VOID: [&str; 4] = ["meta", "link", "img", "!doctype"];

/// Tags that are closed out of order or left open.
fn unbalanced(page: &str) -> Vec<String> {
    let (mut open, mut faults): (Vec<&str>, Vec<String>) = (Vec::new(), Vec::new());
    for part in page.split('<').skip(1) {
        let tag = part.split('>').next().unwrap();
        let name = tag.trim_start_matches('/').split(|c: char| c.is_whitespace() || c == '/').next().unwrap();
        if tag.starts_with('/') {
            if open.pop() != Some(name) {
                faults.push(format!("</{name}>"));
            }
        } else if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
    }
    faults.extend(open.into_iter().map(String::from));
    faults
}

/// All values of an attribute.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    page.split(&format!("{attribute}=\"")).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

#[test]
fn an_unbalanced_page_is_seen() {
    assert_eq!(unbalanced("<p>a<b>c</b></p><img src=x><path d/>"), Vec::<String>::new());
    assert_eq!(unbalanced("<div><p>a</div>"), ["</div>", "div"]);
}

#[test]
fn what_can_not_be_done_is_refused_before_anything_is_measured() {
    let here = folder(&[("file", "text"), ("other.txt", "")]);
    bad(&here, "report -o file", 2, &["-o: not a folder", "found file", "expected"]);
    bad(&here, "report -o .", 2, &["not written over", "an earlier report"]);
    bad(&here, "report -o no/such", 2, &["-o: the folder can't be written", "found no/such"]);
    bad(&here, "report -o /proc/report", 2, &["-o: the folder can't be written"]);
    bad(&here, "report -o r --only devices,colours", 2, &["--only: no such section; found colours", "pareto, modes"]);
    bad(&here, "report -o r --device nothing", 3, &["looking for device \"nothing\""]);
    bad(&here, "report -o r --only mertens/table9", 2, &["--only: no such section", "mertens/table5"]);
    for line in ["--only devices", "--only mertens/table3", "--only mertens --quick", "--quick"] {
        bad(&here, &format!("report file -o r {line}"), 2, &["no section measures meshes", "found file"]);
    }
    // Before the device is opened, and the folder made.
    bad(&here, "report gone.obj -o r --only mertens/table4 --device nothing", 2, &["found gone.obj"]);
    bad(
        &here,
        "report -o r --only devices --history file",
        2,
        &["--history: no section draws these runs", "found file"],
    );
    bad(&here, "report", 2, &["-o"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_table_or_figure_comes_by_its_name() {
    let here = folder(&[]);
    let (_, err) = good(&here, "report -o r --device cpu --only mertens/figure3,mertens/figure4");
    assert!(err.contains("1/2 mertens/figure3") && err.contains("2/2 mertens/figure4"), "{err}");
    let page = read(&here, "r/index.html");
    assert!(page.contains("<section id=\"mertens/figure3\">") && !page.contains("Tables 3, 4 and 5"), "{page}");
    assert_eq!(names(&here.path().join("r")), ["figure-3.csv", "figure-4.csv", "index.html"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn tables_of_mertens_come_for_a_mesh_too() {
    let here = folder(&[("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
    good(&here, "report one.obj -o r --quick --only mertens/table3,mertens/table4,mertens/table5");
    let page = read(&here, "r/index.html");
    for (section, tables) in [
        ("mertens/table3", &["table-3-sphere", "table-3-lotus"][..]),
        ("mertens/table4", &["table-4"]),
        ("mertens/table5", &["table-5", "table-5-mesh-1"]),
    ] {
        let (_, from) = page.split_once(&format!("<section id=\"{section}\">")).unwrap();
        let own = values(from.split("</section>").next().unwrap(), "href");
        let files: Vec<String> = tables.iter().map(|name| format!("{name}.csv")).collect();
        assert_eq!(own, files, "{section}");
    }
    assert!(read(&here, "r/table-4.csv").lines().last().unwrap().starts_with("-,-,-,-,-,one,"));
    let csv = read(&here, "r/table-5-mesh-1.csv");
    assert!(csv.starts_with("meters,") && csv.lines().count() == read(&here, "r/table-5.csv").lines().count(), "{csv}");
}

/// A report whose second section is a file too large is an interrupted one, which goes on there.
#[cfg(unix)]
#[test]
fn an_interrupted_report_goes_on() {
    let here = folder(&[("h.jsonl", include_str!("../results/1/history.jsonl"))]);
    let line = "report -o r --device cpu --only devices,history --history h.jsonl";
    let script = format!("trap '' XFSZ; ulimit -f 40; exec {} {line}", env!("CARGO_BIN_EXE_milkglass"));
    let output = std::process::Command::new("sh").current_dir(here.path()).args(["-c", &script]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{:?}", said(&output));
    assert!(read(&here, "r/index.html").contains("Unfinished: 1 of 2 sections"));
    for (other, key) in
        [("report -o r --device cpu --only devices", "sections"), (&format!("{line} --quick"), "extent")]
    {
        bad(&here, &format!("{other} --resume"), 2, &[&format!("r/unfinished.json: {key}: the interrupted report is")]);
    }
    let (_, err) = good(&here, &format!("{line} --resume"));
    assert!(err.contains("2/2 history") && !err.contains("devices"), "{err}");
    let resumed = read(&here, "r/index.html");
    assert_eq!(
        names(&here.path().join("r")),
        ["devices.csv", "history-1.csv", "history-2.csv", "history-3.csv", "index.html"]
    );
    bad(&here, &format!("{line} --resume"), 2, &["r/unfinished.json", "expected the folder of an interrupted report"]);
    // The page is that of a report in one go, but for the seconds that its sections took.
    good(&here, line);
    let untimed = |page: &str| -> Vec<String> {
        page.lines().filter(|line| !line.contains("class=\"took\"")).map(String::from).collect()
    };
    assert_eq!(untimed(&resumed), untimed(&read(&here, "r/index.html")));
}

#[test]
fn the_guide_names_every_section() {
    let guide = std::fs::read_to_string("src/guide/measuring.md").unwrap();
    for section in SECTIONS {
        assert!(guide.contains(&format!("| `{}` |", section.name)), "the guide's table lacks section {}", section.name);
    }
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn a_page_that_needs_nothing_else() {
        let here = folder(&[]);
        let (out, err) = good(&here, "report -o r --quick --only devices,plan,compile,layers");
        assert_eq!(out.trim(), "r/index.html");
        assert!(
            ["1/4 devices", "2/4 plan", "3/4 compile", "4/4 layers"].iter().all(|section| err.contains(section)),
            "{err}"
        );
        let page = read(&here, "r/index.html");
        assert_eq!(unbalanced(&page), Vec::<String>::new());
        // Where RADV is not installed, the section says so.
        assert!(page.contains("navi21: Null hardware") || page.contains("navi21 is not shown: "));
        for name in ["devices", "plan", "compile", "layers"] {
            assert!(page.contains(&format!("<section id=\"{name}\">")), "{name}");
        }
        assert!(!page.contains("id=\"stress\""), "only what was asked for");
        // Findings link to their section, and columns are explained.
        assert!(page.contains("href=\"#layers\"") && page.contains("<dt>relief, ms</dt><dd>time of stage relief</dd>"));
        // The page fetches nothing and runs no script.
        for word in ["http:", "https:", "<script", "url(", "@import", "<iframe", "javascript"] {
            assert!(!page.contains(word), "{word}");
        }
        let pictures = values(&page, "src");
        assert!(pictures.len() >= 9 && pictures.iter().all(|src| src.starts_with("data:image/png;base64,iVBOR")));
        let files = names(&here.path().join("r"));
        for href in values(&page, "href") {
            assert!(href.starts_with('#') || href == "data:," || files.iter().any(|file| file == href), "{href}");
        }
        assert!(page.matches("<svg").count() >= 2 && page.contains("name=\"viewport\""));
        for words in ["Error by time, fish", "stage relief, ms", "paper&#39;s rule"] {
            assert!(page.contains(words) || page.contains(&words.replace("&#39;", "'")), "{words}");
        }
        // The CSV files contain what the tables show.
        let csv = read(&here, "r/layers.csv");
        assert!(csv.starts_with("scene,rule,samples,") && csv.lines().count() == 1 + 3 * 2 * 3, "{csv}");
        assert!(files.iter().any(|file| file == "plan.csv") && read(&here, "r/plan.csv").contains("\nlotus,"));

        // A second report with fewer sections replaces the page and leaves other files alone.
        std::fs::write(here.path().join("r/notes.txt"), "mine").unwrap();
        good(&here, "report -o r --only devices,conform --device cpu");
        let page = read(&here, "r/index.html");
        assert!(page.contains("The CPU is the reference itself") && !page.contains("id=\"layers\""));
        assert_eq!(unbalanced(&page), Vec::<String>::new());
        assert_eq!((read(&here, "r/notes.txt").as_str(), names(here.path())), ("mine", vec!["r".to_string()]));
    }
}
