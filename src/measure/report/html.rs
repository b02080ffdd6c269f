//! A section of the page as HTML: text, tables whose columns are explained, plots, pictures, findings.

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::measure::table::Table;

/// A section's content: HTML, files beside the page, findings, and failed checks.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Page {
    body: String,
    /// The section for a terminal: all but plots and pictures.
    pub text: String,
    /// Name and bytes of each file beside the page.
    #[serde(skip)]
    pub files: Vec<(String, Vec<u8>)>,
    /// Findings for the front of the page, wins and losses alike.
    pub findings: Vec<Finding>,
    /// Verdicts for the front of the page: a short text, what it is about, and its tone.
    pub tiles: Vec<(String, String, Tone)>,
    /// The section's part of the front of the page: a chart or pictures, as HTML.
    pub front: String,
    /// Checks that failed.
    pub faults: Vec<String>,
    /// Whether anything was checked that can fail.
    pub checked: bool,
}

/// A comparison with an aim: what was asked for, and what was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// The verdict.
    pub tone: Tone,
    /// What is compared, and with what.
    pub aim: String,
    /// What was measured.
    pub found: String,
}

/// The verdict of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tone {
    /// As good as what it is compared with, or better.
    Win,
    /// Worse than what it is compared with.
    Loss,
    /// Neither.
    Note,
}

impl Tone {
    /// A win if this holds.
    pub fn of(won: bool) -> Self {
        if won { Self::Win } else { Self::Loss }
    }

    /// The verdict's style class and its word.
    pub fn mark(self) -> (&'static str, &'static str) {
        match self {
            Self::Win => ("win", "met"),
            Self::Loss => ("loss", "missed"),
            Self::Note => ("note", "note"),
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

impl Page {
    /// Adds a paragraph.
    pub fn say(&mut self, words: &str) {
        self.body += &format!("<p>{}</p>\n", escape(words));
        self.text += &format!("{words}\n");
    }

    /// Adds a heading within the section.
    pub fn head(&mut self, words: &str) {
        self.body += &format!("<h3>{}</h3>\n", escape(words));
        self.text += &format!("\n{words}\n");
    }

    /// Adds a failed check.
    pub fn fail(&mut self, words: &str) {
        self.body += &format!("<p class=\"fail\">FAILS: {}</p>\n", escape(words));
        self.text += &format!("FAILS: {words}\n");
        self.faults.push(words.into());
    }

    /// Adds a finding, for the table at the front of the page.
    pub fn find(&mut self, tone: Tone, aim: &str, found: &str) {
        self.findings.push(Finding { tone, aim: aim.into(), found: found.into() });
    }

    /// Adds a tile to the front of the page: a short verdict, and what it is about.
    pub fn tile(&mut self, tone: Tone, verdict: &str, about: &str) {
        self.tiles.push((verdict.into(), about.into(), tone));
    }

    /// Moves what `write` adds to the front of the page.
    pub fn to_front(&mut self, write: impl FnOnce(&mut Self)) {
        let [body, text] = [&mut self.body, &mut self.text].map(std::mem::take);
        write(self);
        self.front += &std::mem::replace(&mut self.body, body);
        self.text = text;
    }

    /// Adds a part that is folded until the reader opens it.
    pub fn fold(&mut self, head: &str, write: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.body += &format!("<details><summary>{}</summary>\n", escape(head));
        self.text += &format!("\n{head}\n");
        let done = write(self);
        self.body += "</details>\n";
        done
    }

    /// Adds a table, and the same table as a file `name.csv`.
    pub fn table(&mut self, name: &str, table: &Table) -> Result<()> {
        let text = table.csv()?;
        self.small_table(table);
        self.file(&format!("{name}.csv"), text.into_bytes());
        Ok(())
    }

    /// Adds a table without a file. A wide one scrolls inside its box.
    pub fn small_table(&mut self, table: &Table) {
        self.text += &format!("\n{}", table.text());
        let class = |k: usize| if table.is_numeric(k) { " class=\"r\"" } else { "" };
        let head = |(k, [head, meaning]): (usize, &[String; 2])| {
            let title = if meaning.is_empty() { String::new() } else { format!(" title=\"{}\"", escape(meaning)) };
            format!("<th{}{title}>{}</th>", class(k), escape(head))
        };
        self.body += "<div class=\"box\" tabindex=\"0\"><table>\n";
        self.body += &format!("<tr>{}</tr>\n", table.columns.iter().enumerate().map(head).collect::<String>());
        for row in &table.rows {
            let cell = |(k, cell): (usize, &String)| format!("<td{}>{}</td>", class(k), escape(cell));
            self.body += &format!("<tr>{}</tr>\n", row.iter().enumerate().map(cell).collect::<String>());
        }
        self.body += "</table></div>\n";
        let explained: Vec<_> = table.columns.iter().filter(|[_, meaning]| !meaning.is_empty()).collect();
        if explained.is_empty() {
            return;
        }
        self.body += "<details class=\"columns\"><summary>what the columns mean</summary><dl>\n";
        for [head, meaning] in explained {
            self.body += &format!("<dt>{}</dt><dd>{}</dd>\n", escape(head), escape(meaning));
        }
        self.body += "</dl></details>\n";
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
