//! The whole page: one HTML file that refers only to the files beside it, and contains no script. Its front has the
//! verdicts as tiles, error against run time, pictures, and aims beside findings; the sections below it are folded.

use serde::{Deserialize, Serialize};

use super::html::{Page, Tone, escape};

/// The head of the page; its content policy forbids scripts and external resources.
const HEAD: &str = r#"<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="milkglass report">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
<style>
:root{--text:#222;--back:#fff;--soft:#555;--line:#ddd;--faint:#f4f4f4;--win:#05603a;--loss:#a12d00;--link:#0b57a4;
--fail:#b00020}
@media(prefers-color-scheme:dark){:root{--text:#ddd;--back:#161616;--soft:#a0a0a0;--line:#3a3a3a;--faint:#242424;
--win:#5fc796;--loss:#f0936b;--link:#7db5f5;--fail:#a01828}
svg{filter:invert(.9) hue-rotate(180deg)}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--text);background:var(--back);margin:0 auto;max-width:76rem;
padding:0 1rem 4rem}
h1{font-size:1.7rem;margin:1.2rem 0 .2rem}h2{font-size:1.25rem;margin:0;display:inline}
main h2.front{display:block;margin:1.6rem 0 .4rem}
h3{font-size:1.05rem;margin:1.5rem 0 .3rem}p{margin:.5rem 0;max-width:60rem}
.about{color:var(--soft);margin:0 0 1rem}
.tiles{display:grid;grid-template-columns:repeat(auto-fill,minmax(11rem,1fr));gap:.6rem;margin:1rem 0}
.tile{border:1px solid var(--line);border-left:5px solid var(--soft);border-radius:6px;padding:.5rem .8rem;
background:var(--faint);display:block;color:inherit;text-decoration:none}
.tile b{display:block;font-size:1.25rem;line-height:1.25}.tile span{font-size:.85rem;color:var(--soft)}
.tile.win{border-left-color:var(--win)}.tile.win b{color:var(--win)}.tile.loss{border-left-color:var(--loss)}
.tile.loss b{color:var(--loss)}
.box{overflow-x:auto;width:fit-content;max-width:100%;margin:.5rem 0;border:1px solid var(--line);border-radius:4px}
table{border-collapse:collapse;font-size:.85rem;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.2rem .6rem;border-bottom:1px solid var(--line);white-space:nowrap;vertical-align:top}
table.findings td{white-space:normal}td.win,td.loss,td.note{font-weight:600}
th{background:var(--faint)}.r{text-align:right}pre{font-size:.78rem;line-height:1.35;margin:.5rem}
.row{display:flex;flex-wrap:wrap;gap:.8rem;align-items:flex-start}.plot{max-width:100%}
.plot svg{max-width:100%;height:auto}
figure{margin:0}img{display:block;max-width:100%;background:#000;border-radius:3px}
figcaption{font-size:.8rem;color:var(--soft)}
.file{font-size:.8rem;margin:.1rem 0}.fail{background:var(--fail);color:#fff;padding:.4rem .6rem;border-radius:4px}
.win{color:var(--win)}.loss{color:var(--loss)}.note,.took{color:var(--soft)}.took{font-size:.8rem}
a{color:var(--link)}details{margin:.4rem 0}summary{cursor:pointer}.columns{font-size:.85rem;color:var(--soft)}
dl{margin:.3rem 0 .6rem;display:grid;grid-template-columns:max-content 1fr;gap:.1rem .8rem;max-width:60rem}
dt{font-weight:600}dd{margin:0}
@media(max-width:40rem){dl{display:block}dd{margin:0 0 .4rem}}
.section{border-top:1px solid var(--line);margin:0;padding:.7rem 0}.section[open]{padding-bottom:2rem}
</style>
"#;

/// One finished section.
#[derive(Serialize, Deserialize)]
pub struct Written {
    /// Its name, the target of links.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// Its content.
    pub page: Page,
    /// Seconds it took.
    pub seconds: f64,
}

/// The whole page: title, device and host, the front, then the sections; `all` is their number when it is finished.
#[must_use]
pub fn whole(title: &str, about: &[(&str, String)], sections: &[Written], all: usize) -> String {
    let mut text = format!("{HEAD}<title>{0}</title></head><body>\n<header><h1>{0}</h1>\n", escape(title));
    let lines: Vec<String> = about.iter().map(|(key, value)| format!("{}: {}", escape(key), escape(value))).collect();
    text += &format!("<p class=\"about\">{}</p></header>\n<main>\n", lines.join(" \u{b7} "));

    if sections.len() < all {
        let done = sections.len();
        text += &format!(
            "<p class=\"about\">Unfinished: {done} of {all} sections were measured when this was written.</p>\n"
        );
    }

    // Failed checks, before anything else.
    let faults: usize = sections.iter().map(|section| section.page.faults.len()).sum();
    if faults > 0 {
        let word = if faults == 1 { "1 check FAILS".to_string() } else { format!("{faults} checks FAIL") };
        text += &format!("<p class=\"fail\">{word}</p>\n<ul>\n");
        for section in sections {
            for fault in &section.page.faults {
                text += &format!("<li>FAILS: {} <a href=\"#{1}\">{1}</a></li>\n", escape(fault), section.name);
            }
        }
        text += "</ul>\n";
    }

    // Verdicts, a chart, pictures.
    text += "<div class=\"tiles\">\n";
    for Written { name, page, .. } in sections {
        for (verdict, about, tone) in &page.tiles {
            let (class, _) = tone.mark();
            let (verdict, about) = (escape(verdict), escape(about));
            text += &format!("<a class=\"tile {class}\" href=\"#{name}\"><b>{verdict}</b><span>{about}</span></a>\n");
        }
    }
    let device = about.first().map_or("", |(_, device)| device);
    let (met, missed) = (findings(sections, device, true), findings(sections, device, false));
    let checked = faults == 0 && sections.iter().any(|section| section.page.checked);
    text += &badge(checked, met.0, missed.0);
    text += "</div>\n";
    sections.iter().for_each(|section| text += &section.page.front);

    // Aims beside findings; those that were met are folded.
    if met.0 + missed.0 > 0 {
        text +=
            &format!("<h2 class=\"front\" id=\"findings\">Aims: {} missed, {} met</h2>\n{}", missed.0, met.0, missed.1);
        if met.0 > 0 {
            text += &format!("<details><summary>the {} that were met</summary>\n{}</details>\n", met.0, met.1);
        }
    }

    // The sections: folded, those that failed open. A link to a section opens it.
    text += "<h2 class=\"front\" id=\"sections\">Sections</h2>\n";
    for Written { name, title, page, seconds } in sections {
        let open = if page.faults.is_empty() { "" } else { " open" };
        text += &format!("<details class=\"section\"{open}><summary><h2>{}</h2></summary>\n", escape(title));
        text += &format!("<section id=\"{name}\">\n{}", page.body());
        text += &format!("<p class=\"took\">{seconds:.1} s</p></section></details>\n");
    }
    text + "</main></body></html>\n"
}

/// The tile of all aims below it; `checked` where there were checks, too, and all of them passed.
fn badge(checked: bool, met: usize, missed: usize) -> String {
    let (all, checks) = (met + missed, if checked { "every check passes" } else { "listed below" });
    let (class, words, about, place) = match (missed, met) {
        (1.., _) => ("loss", format!("{missed} of {all} aims missed"), checks.to_owned(), "findings"),
        (0, 1..) if checked => ("win", "All aims met".to_owned(), format!("{met} of them; {checks}"), "findings"),
        (0, 1..) => ("win", "All aims met".to_owned(), format!("{met} of them"), "findings"),
        (0, 0) if checked => ("win", "Every check passes".to_owned(), "in the sections below".to_owned(), "sections"),
        (0, 0) => return String::new(),
    };
    format!("<a class=\"tile {class}\" href=\"#{place}\"><b>{words}</b><span>{about}</span></a>\n")
}

/// The number of aims that were met, or missed, and a table of them.
fn findings(sections: &[Written], device: &str, met: bool) -> (usize, String) {
    let (mut count, mut rows) = (0, String::new());
    for Written { name, page, .. } in sections {
        for finding in page.findings.iter().filter(|finding| (finding.tone != Tone::Loss) == met) {
            let ((class, word), device) = (finding.tone.mark(), escape(device));
            let (aim, found) = (escape(&finding.aim), escape(&finding.found));
            count += 1;
            rows += &format!(
                "<tr><td class=\"{class}\">{word}</td><td>{device}</td><td>{aim}</td><td>{found}</td>\
                 <td><a href=\"#{name}\">{name}</a></td></tr>\n"
            );
        }
    }
    if count == 0 {
        return (0, String::new());
    }
    let head = "<tr><th></th><th>device</th><th>aim</th><th>found</th><th>section</th></tr>";
    let open = "<div class=\"box\" tabindex=\"0\"><table class=\"findings\">";
    (count, format!("{open}\n{head}\n{rows}</table></div>\n"))
}

/// The verdict of a section whose checks can fail, for its tile.
pub fn verdict(page: &mut Page, passed: &str, about: &str) {
    page.checked = true;
    match page.faults.len() {
        0 => page.tile(Tone::Win, passed, about),
        1 => page.tile(Tone::Loss, "1 check FAILS", about),
        n => page.tile(Tone::Loss, &format!("{n} checks FAIL"), about),
    }
}
