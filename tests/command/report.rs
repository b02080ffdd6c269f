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
    for key in ["--history", "--from"] {
        let said = format!("{key}: no section shows this");
        bad(&here, &format!("report -o r --only devices {key} file"), 2, &[&said, "found file"]);
    }
    bad(&here, "report", 2, &["-o"]);
    bad(&here, "report -o r --only day", 2, &["--only: this section shows what a file has", "expected --from DAY"]);
    bad(&here, "report -o r --from no", 2, &["no/summary.txt: could not be read", "day.tar.gz"]);
    std::fs::write(here.path().join("summary.txt"), "no step\n").unwrap();
    bad(&here, "report -o r --from .", 2, &["summary.txt: it names no step"]);
    std::fs::write(here.path().join("summary.txt"), "a exit 0 1 s x\n").unwrap();
    std::fs::write(here.path().join("a.json"), "{}").unwrap();
    bad(&here, "report -o r --from .", 2, &["a.json: schema: this version of the format is not known"]);
    std::fs::remove_file(here.path().join("a.json")).unwrap();
    std::os::unix::fs::symlink("/etc/hostname", here.path().join("lotus.png")).unwrap();
    bad(&here, "report -o r --from .", 2, &["lotus.png: not a plain file"]);
    std::fs::remove_file(here.path().join("lotus.png")).unwrap();
    std::fs::write(here.path().join("lotus.png"), "secret").unwrap();
    bad(&here, "report -o r --from .", 2, &["lotus.png: not a PNG file"]);
    std::fs::write(here.path().join("summary.txt"), "a exit 0 1 s x\na exit 0 1 s x\n").unwrap();
    bad(&here, "report -o r --from .", 2, &["summary.txt:2: a step of an earlier name", "found a"]);
    assert!(!here.path().join("r").exists());
}

#[test]
fn a_day_of_another_device_stands_beside_this_one() {
    let here = folder(&[]);
    std::fs::create_dir(here.path().join("day")).unwrap();
    std::fs::write(here.path().join("day/lotus.png"), b"\x89PNG\r\n\x1a\n").unwrap();
    let sets = "--set object.0.detail=1 --set camera.size=[8,8] --device cpu --frames 3";
    good(&here, &format!("profile sphere {sets} --change light --save day/light.json"));
    let lines = "devices exit 0 1 s a device\nlight exit 124 30 s 0.2 ms\nvary: no time left\n";
    std::fs::write(here.path().join("day/summary.txt"), lines).unwrap();
    // The scene of this one is nowhere.
    let lost = read(&here, "day/light.json").replace("\"sphere\"", "\"gone.obj\"");
    std::fs::write(here.path().join("day/devices.json"), lost).unwrap();
    let (_, err) = good(&here, "report --from day -o r --device cpu");
    assert!(err.contains("1/1 day"), "{err}");
    let page = read(&here, "r/index.html");
    for words in [
        "<td>vary</td>",
        "no time left",
        "light: sphere, light changes",
        "Not timed here: neither a built-in scene nor a file; found gone.obj",
        "base64,iVBORw0KGgo=",
    ] {
        assert!(page.contains(words), "{words}: {page}");
    }
    let csv = read(&here, "r/day-light.csv");
    assert!(csv.starts_with("what,\"there, ms\",\"here, ms\",here / there\n"), "{csv}");
    let row = csv.lines().find(|line| line.starts_with("gather,")).unwrap();
    assert!(row.split(',').skip(1).all(|cell| cell.parse::<f64>().is_ok_and(|ms| ms > 0.0)), "{row}");
    let row = read(&here, "r/day-devices.csv");
    assert!(row.lines().any(|line| line.starts_with("gather,") && line.ends_with(",,")), "{row}");
}

#[test]
fn comparisons_that_differ_on_another_device_are_failures() {
    let here = folder(&[]);
    std::fs::create_dir(here.path().join("day")).unwrap();
    let ended = |code: u8| {
        std::fs::write(here.path().join("day/summary.txt"), format!("conform exit {code} 9 s x\n")).unwrap();
    };
    ended(0);
    good(&here, "conform --filter ^one.triangle --stage refit --no-validation --jsonl day/conform.jsonl");
    good(&here, "report --from day -o r --device cpu");
    let differs = read(&here, "day/conform.jsonl").replacen("\"conforms\"", "\"differs\"", 1);
    std::fs::write(here.path().join("day/conform.jsonl"), differs).unwrap();
    ended(1);
    bad(&here, "report --from day -o r --device cpu", 1, &["the report has 1 failures", "day: ", "refit"]);
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
fn figure_2_of_kubo_comes_for_a_mesh_too() {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let here = folder(&[("one.obj", &format!("{corners}f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"))]);
    good(&here, "report one.obj -o r --quick --only kubo/figure2");
    let page = read(&here, "r/index.html");
    assert_eq!(values(&page, "src").len(), 4);
    assert!(
        page.contains("sphere: scattering hides small bumps") && page.contains("with scattering (dipole)"),
        "{page}"
    );
    let csv = read(&here, "r/kubo-figure-2.csv");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert!(rows.len() == 3 && rows[2][0] == "one.obj", "{csv}");
    // Bumps stay visible by the cosine, and more than half of them goes by the dipole.
    let [cosine, dipole] = [1, 2].map(|k: usize| rows[1][k].parse::<f64>().unwrap());
    assert!(cosine > 0.05 && dipole < 0.5 * cosine && dipole > 0.0, "{csv}");
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
    let runs = include_str!("../results/1/history.jsonl");
    let here = folder(&[("h.jsonl", runs), ("less.jsonl", &runs[..=runs.find('\n').unwrap()])]);
    let line = "report -o r --device cpu --only devices,history --history h.jsonl";
    let script = format!("trap '' XFSZ; ulimit -f 40; exec {} {line}", env!("CARGO_BIN_EXE_milkglass"));
    let output = std::process::Command::new("sh").current_dir(here.path()).args(["-c", &script]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{:?}", said(&output));
    assert!(read(&here, "r/index.html").contains("Unfinished: 1 of 2 sections"));
    for (other, key) in [
        ("report -o r --device cpu --only devices", "sections"),
        (&format!("{line} --quick"), "extent"),
        (&line.replace("h.jsonl", "less.jsonl"), "history"),
    ] {
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
