//! The README and the guide: their size, their links, and that every block marked `sh` runs.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use milkglass::Scene;

/// The tag of commands that take long, change the machine, or need files or devices that the test lacks.
const SLOW: &str = "sh slow";

/// README and the pages of the guide.
fn pages() -> Vec<PathBuf> {
    let guide = fs::read_dir("src/guide").unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> = guide.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    pages.sort();
    assert!(pages.len() >= 13, "pages of the guide are missing");
    pages.insert(0, "README.md".into());
    pages
}

/// A page's code blocks, with their tags, and its other lines.
fn parts(text: &str) -> (Vec<(String, String)>, Vec<&str>) {
    let (mut blocks, mut prose): (Vec<(String, String)>, Vec<&str>) = Default::default();
    let mut open = false;
    for line in text.lines() {
        match line.trim_start().strip_prefix("```") {
            Some(_) if open => open = false,
            Some(tag) => {
                open = true;
                blocks.push((tag.to_string(), String::new()));
            }
            None if open => {
                let block = &mut blocks.last_mut().unwrap().1;
                // Blocks of a list are indented.
                block.push_str(if line.starts_with("   ") && blocks_indented(text, line) { &line[3..] } else { line });
                block.push('\n');
            }
            None => prose.push(line),
        }
    }
    assert!(!open, "a code block does not end");
    (blocks, prose)
}

/// Whether the block of this line starts with an indented fence.
fn blocks_indented(text: &str, line: &str) -> bool {
    let at = line.as_ptr() as usize - text.as_ptr() as usize;
    text[..at].lines().rev().find(|before| before.trim_start().starts_with("```")).is_some_and(|f| f.starts_with("   "))
}

/// The anchor of a heading, as repositories' web pages make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Text without `code`.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("``")
}

/// The faults of a page's links.
fn dead_links(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).unwrap();
    let (_, prose) = parts(&text);
    let folder = page.parent().unwrap();
    let anchors: HashSet<String> = prose.iter().filter(|line| line.starts_with('#')).map(|line| anchor(line)).collect();
    let mut faults = Vec::new();
    let check = |target: &str| {
        let found = match target.strip_prefix('#') {
            Some(inside) => anchors.contains(inside),
            None => folder.join(target).is_file(),
        };
        (!found).then(|| format!("{}: {target} is not there", page.display()))
    };
    let mut defined = HashMap::new();
    for line in &prose {
        if let Some((label, target)) = line.strip_prefix('[').and_then(|rest| rest.split_once("]: ")) {
            faults.extend(check(target));
            defined.insert(label.to_string(), false);
        }
    }
    let all: String = prose.iter().filter(|line| !line.contains("]: ")).map(|line| without_code(line) + "\n").collect();
    let mut rest = all.as_str();
    while let Some(at) = rest.find(']') {
        let inner = rest[..at].rfind('[').map_or("", |start| &rest[start + 1..at]);
        rest = &rest[at + 1..];
        let label = if let Some(target) = rest.strip_prefix('(') {
            faults.extend(check(&target[..target.find(')').unwrap()]));
            continue;
        } else if let Some(after) = rest.strip_prefix('[') {
            let label = &after[..after.find(']').unwrap()];
            rest = &after[label.len() + 1..];
            label
        } else {
            inner
        };
        match defined.get_mut(label) {
            Some(used) => *used = true,
            None => faults.push(format!("{}: [{label}] has no definition", page.display())),
        }
    }
    let unused = defined.iter().filter(|(_, used)| !**used);
    faults.extend(unused.map(|(label, _)| format!("{}: [{label}] is never used", page.display())));
    faults
}

#[test]
fn links_lead_somewhere() {
    let faults: Vec<String> = pages().iter().flat_map(|page| dead_links(page)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));

    // The check itself finds what is dead.
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    fs::write(&page, "# A b\n[x](#a-b) [y](#c) [z] [w][v] `[k]`\n\n[v]: none.md\n[u]: page.md\n").unwrap();
    let found = dead_links(&page).join("\n");
    for fault in ["#c is not", "[z] has no", "none.md is not", "[u] is never"] {
        assert!(found.contains(fault), "{fault}: {found}");
    }
    assert_eq!(found.lines().count(), 4, "{found}");
}

#[test]
fn pages_are_short_and_their_blocks_tagged() {
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        let most = if page.ends_with("README.md") { 200 } else { 250 };
        assert!(text.lines().count() <= most, "{} has more than {most} lines", page.display());
        for (tag, _) in parts(&text).0 {
            let known = ["sh", SLOW, "toml", "text", "glsl", "rust", "rust no_run"];
            assert!(known.contains(&tag.as_str()), "{}: a block is tagged {tag:?}", page.display());
        }
    }
}

/// README's example is the front page's, which a crate elsewhere builds and runs.
#[test]
fn the_example_is_everywhere_the_same() {
    let first = |text: &str| parts(text).0.into_iter().find(|(tag, _)| tag.starts_with("rust")).unwrap().1;
    let front = fs::read_to_string("src/lib.rs").unwrap();
    let front: String = front
        .lines()
        .map_while(|line| line.strip_prefix("//!"))
        .map(|line| format!("{}\n", line.strip_prefix(' ').unwrap_or(line)))
        .collect();
    let own = |tag: &str| parts(&front.replace("```no_run", tag)).0[0].1.clone();
    for page in ["README.md", "src/guide/library.md"] {
        assert_eq!(first(&fs::read_to_string(page).unwrap()), own("```rust"), "{page}");
    }
}

/// A small closed mesh, as an OBJ file.
fn write_ball(path: &Path) {
    let mesh = &Scene::load_with("sphere", &["object.0.detail=3".to_string()]).unwrap().objects[0].mesh;
    let mut text = String::new();
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y * 0.8, p.z + 0.2 * p.x * p.y);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    fs::write(path, text).unwrap();
}

/// Runs a page's blocks in order, in a folder of their own with `bunny.obj`.
fn run(page: &Path) -> usize {
    let folder = tempfile::tempdir().unwrap();
    write_ball(&folder.path().join("bunny.obj"));
    let binary = Path::new(env!("CARGO_BIN_EXE_milkglass")).parent().unwrap();
    let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap());
    let (blocks, _) = parts(&fs::read_to_string(page).unwrap());
    let blocks: Vec<String> = blocks.into_iter().filter(|(tag, _)| tag == "sh").map(|(_, block)| block).collect();
    for block in &blocks {
        let done = Command::new("sh").args(["-euc", block]).current_dir(&folder).env("PATH", &path).output().unwrap();
        let [out, err] = [&done.stdout, &done.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        assert!(done.status.success(), "{}: this block fails\n{block}\n{out}\n{err}", page.display());
    }
    blocks.len()
}

/// Two threads: half of the work of a command keeps only one core busy.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn commands_in_the_pages_run() {
    let pages = pages();
    let (odd, even): (Vec<_>, Vec<_>) = pages.iter().enumerate().partition(|(k, _)| k % 2 == 1);
    let all = |pages: Vec<(usize, &PathBuf)>| pages.into_iter().map(|(_, page)| run(page)).sum::<usize>();
    let count = std::thread::scope(|scope| {
        let other = scope.spawn(|| all(odd));
        all(even) + other.join().unwrap()
    });
    assert!(count >= 20, "only {count} blocks were run");
}
