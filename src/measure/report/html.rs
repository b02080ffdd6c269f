//! The page: one HTML file that refers only to the files beside it, and contains no script.

use crate::error::{Error, Result};

/// A section's content: HTML, files beside the page, findings, and failed checks.
#[derive(Debug, Default)]
pub struct Page {
    body: String,
    /// Name and bytes of each file beside the page.
    pub files: Vec<(String, Vec<u8>)>,
    /// Findings for the top of the page, wins and losses alike.
    pub findings: Vec<(Tone, String)>,
    /// Checks that failed.
    pub faults: Vec<String>,
}

/// The verdict of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// As good as what it is compared with, or better.
    Win,
    /// Worse than what it is compared with.
    Loss,
    /// Neither.
    Note,
}

impl Tone {
    fn mark(self) -> (&'static str, &'static str) {
        match self {
            Self::Win => ("win", "+"),
            Self::Loss => ("loss", "\u{2212}"),
            Self::Note => ("note", "\u{b7}"),
        }
    }
}

/// A picture on the page.
pub struct Shown {
    /// Its caption.
    pub label: String,
    /// Its width, pixels.
    pub width: u32,
    /// The picture as a PNG file.
    pub png: Vec<u8>,
}

/// Escapes text for HTML.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Whether a cell holds a number, perhaps with a unit or a bound; columns of numbers are right-aligned.
fn numeric(cell: &str) -> bool {
    let bare = cell.trim_start_matches(['<', '>', '=', '\u{b1}', '+', '-', ' ']);
    bare.starts_with(|c: char| c.is_ascii_digit()) && bare.chars().filter(|c| c.is_alphabetic()).count() <= 5
        || matches!(cell, "" | "-")
}

impl Page {
    /// Adds a paragraph.
    pub fn say(&mut self, words: &str) {
        self.body += &format!("<p>{}</p>\n", escape(words));
    }

    /// Adds a heading within the section.
    pub fn head(&mut self, words: &str) {
        self.body += &format!("<h3>{}</h3>\n", escape(words));
    }

    /// Adds a failed check.
    pub fn fail(&mut self, words: &str) {
        self.body += &format!("<p class=\"fail\">FAILS: {}</p>\n", escape(words));
        self.faults.push(words.into());
    }

    /// Adds a finding, which also appears at the top of the page.
    pub fn find(&mut self, tone: Tone, words: &str) {
        let (class, mark) = tone.mark();
        self.body += &format!("<p class=\"{class}\">{mark} {}</p>\n", escape(words));
        self.findings.push((tone, words.into()));
    }

    /// Adds a part that is folded until the reader opens it.
    pub fn fold(&mut self, head: &str, write: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.body += &format!("<details><summary>{}</summary>\n", escape(head));
        let done = write(self);
        self.body += "</details>\n";
        done
    }

    /// Adds a table, and the same table as a file `name.csv`.
    pub fn table(&mut self, name: &str, header: &[&str], rows: &[Vec<String>]) -> Result<()> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let lost = |error: &dyn std::fmt::Display| Error::Check(format!("{name}.csv could not be made: {error}"));
        writer.write_record(header).map_err(|e| lost(&e))?;
        for row in rows {
            writer.write_record(row).map_err(|e| lost(&e))?;
        }
        let bytes = writer.into_inner().map_err(|e| lost(&e))?;
        self.small_table(header, rows);
        self.file(&format!("{name}.csv"), bytes);
        Ok(())
    }

    /// Adds a table without a file.
    pub fn small_table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        let right = |k: usize| !rows.is_empty() && rows.iter().all(|row| row.get(k).is_none_or(|cell| numeric(cell)));
        let right: Vec<bool> = (0..header.len()).map(right).collect();
        let class = |k: usize| if right.get(k) == Some(&true) { " class=\"r\"" } else { "" };
        let line = |tag: &str, cells: &mut dyn Iterator<Item = &str>| {
            let cell = |(k, cell): (usize, &str)| format!("<{tag}{}>{}</{tag}>", class(k), escape(cell));
            format!("<tr>{}</tr>\n", cells.enumerate().map(cell).collect::<String>())
        };
        self.body += "<div class=\"box\"><table>\n";
        if header.iter().any(|head| !head.is_empty()) {
            self.body += &line("th", &mut header.iter().copied());
        }
        for row in rows {
            self.body += &line("td", &mut row.iter().map(String::as_str));
        }
        self.body += "</table></div>\n";
    }

    /// Adds a file beside the page, with a link to it.
    pub fn file(&mut self, name: &str, bytes: Vec<u8>) {
        self.body += &format!("<p class=\"file\"><a href=\"{0}\">{0}</a></p>\n", escape(name));
        self.files.push((name.into(), bytes));
    }

    /// Adds a plot; a wide one scrolls if there is not enough space.
    pub fn plot(&mut self, svg: &str, wide: bool) {
        // HTML does not need the namespace.
        let svg = svg.replace(" xmlns=\"http://www.w3.org/2000/svg\"", "");
        let class = if wide { "box wide" } else { "plot" };
        self.body += &format!("<div class=\"{class}\">{svg}</div>\n");
    }

    /// Adds several plots, side by side if there is space.
    pub fn plots(&mut self, svgs: &[String]) {
        self.body += "<div class=\"row\">\n";
        svgs.iter().for_each(|svg| self.plot(svg, false));
        self.body += "</div>\n";
    }

    /// Adds pictures, side by side if there is space.
    pub fn pictures(&mut self, pictures: &[Shown]) {
        use base64::Engine;
        self.body += "<div class=\"row\">\n";
        for Shown { label, width, png } in pictures {
            let data = base64::engine::general_purpose::STANDARD.encode(png);
            let label = escape(label);
            self.body += &format!(
                "<figure style=\"max-width:min(100%,{width}px)\"><img alt=\"{label}\" src=\"data:image/png;base64,{data}\"><figcaption>{label}</figcaption></figure>\n"
            );
        }
        self.body += "</div>\n";
    }

    /// The section's HTML.
    #[must_use]
    pub fn body(&self) -> &str {
        &self.body
    }
}

/// The head of the page; its content policy forbids scripts and external resources.
const HEAD: &str = r#"<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="milkglass report">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
<style>
body{font:16px/1.5 system-ui,sans-serif;color:#222;background:#fff;margin:0 auto;max-width:76rem;padding:0 1rem 4rem}
h1{font-size:1.6rem;margin:1.2rem 0 .3rem}h2{font-size:1.3rem;margin:2.5rem 0 .5rem;border-top:1px solid #ccc;padding-top:1rem}
h3{font-size:1.05rem;margin:1.5rem 0 .3rem}p{margin:.5rem 0;max-width:60rem}
.box{overflow-x:auto;width:fit-content;max-width:100%;margin:.5rem 0;border:1px solid #ddd;border-radius:4px}
table{border-collapse:collapse;font-size:.85rem;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.2rem .6rem;border-bottom:1px solid #eee;white-space:nowrap;vertical-align:top}
th{background:#f4f4f4}.r{text-align:right}pre{font-size:.78rem;line-height:1.35;margin:.5rem}
.row{display:flex;flex-wrap:wrap;gap:.8rem;align-items:flex-start}.plot{max-width:100%}.plot svg{max-width:100%;height:auto}
figure{margin:0}img{display:block;max-width:100%;background:#000}figcaption{font-size:.8rem;color:#555}
.file{font-size:.8rem;margin:.1rem 0}.fail{background:#b00020;color:#fff;padding:.4rem .6rem;border-radius:4px}
.win{color:#05603a}.loss{color:#a12d00}.note,.took{color:#555}.took{font-size:.8rem}
nav a{display:inline-block;margin:.15rem .8rem .15rem 0}a{color:#0b57a4}details{margin:.4rem 0}summary{cursor:pointer}
</style>
"#;

/// One finished section.
pub struct Written {
    /// Its name, the target of links.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Its content.
    pub page: Page,
    /// Seconds it took.
    pub seconds: f64,
}

/// The whole page: title, device and host, findings, then the sections.
#[must_use]
pub fn whole(title: &str, about: &[(&str, String)], sections: &[Written]) -> String {
    let mut text = format!("{HEAD}<title>{0}</title></head><body>\n<header><h1>{0}</h1>\n", escape(title));
    let mut top = Page::default();
    top.small_table(
        &["", ""],
        &about.iter().map(|(key, value)| vec![(*key).into(), value.clone()]).collect::<Vec<_>>(),
    );
    text += top.body();
    text += "</header>\n<nav>";
    for section in sections {
        text += &format!("<a href=\"#{}\">{}</a>", section.name, escape(section.title));
    }
    text += "</nav>\n<main>\n<h2 id=\"findings\">What was found</h2>\n";
    let faults: usize = sections.iter().map(|section| section.page.faults.len()).sum();
    text += &match faults {
        0 => "<p>Every check passes. Wins (+) and losses (\u{2212}):</p>\n<ul>\n".to_string(),
        1 => "<p class=\"fail\">1 check FAILS</p>\n<ul>\n".to_string(),
        n => format!("<p class=\"fail\">{n} checks FAIL</p>\n<ul>\n"),
    };
    for section in sections {
        let from = format!(" <a href=\"#{0}\">{0}</a>", section.name);
        for fault in &section.page.faults {
            text += &format!("<li class=\"loss\">FAILS: {}{from}</li>\n", escape(fault));
        }
        for (tone, words) in &section.page.findings {
            let (class, mark) = tone.mark();
            text += &format!("<li class=\"{class}\">{mark} {}{from}</li>\n", escape(words));
        }
    }
    text += "</ul>\n";
    for Written { name, title, page, seconds } in sections {
        text += &format!("<section id=\"{name}\"><h2>{}</h2>\n{}", escape(title), page.body());
        text += &format!("<p class=\"took\">{seconds:.1} s</p></section>\n");
    }
    text + "</main></body></html>\n"
}
