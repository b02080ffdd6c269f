//! The result of a measurement as a table; text, CSV and HTML are ways to write it.

use crate::error::{Error, Result};

/// A column: its heading, what its values mean, with their unit, and its cell of a row. The meaning is empty if the
/// heading needs no explanation.
pub type Column<'a, R> = (&'a str, &'a str, &'a dyn Fn(&R) -> String);

/// A table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// The heading and the meaning of each column.
    pub columns: Vec<[String; 2]>,
    /// The cells of each row.
    pub rows: Vec<Vec<String>>,
}

/// Whether a cell holds a number, perhaps with a unit or a bound; columns of numbers are aligned to the right.
pub(super) fn numeric(cell: &str) -> bool {
    let bare = cell.trim_start_matches(['<', '>', '=', '\u{b1}', '+', '-', ' ']);
    bare.starts_with(|c: char| c.is_ascii_digit()) && bare.chars().filter(|c| c.is_alphabetic()).count() <= 5
        || matches!(cell, "" | "-")
}

impl Table {
    /// The table of these rows.
    pub fn of<R>(rows: &[R], columns: &[Column<'_, R>]) -> Self {
        let cells = rows.iter().map(|row| columns.iter().map(|(.., cell)| cell(row)).collect());
        Self::new(columns.iter().map(|(head, meaning, _)| (*head, *meaning)), cells.collect())
    }

    /// A table of these cells, under these headings with their meanings.
    pub fn new<'a>(columns: impl IntoIterator<Item = (&'a str, &'a str)>, rows: Vec<Vec<String>>) -> Self {
        Self { columns: columns.into_iter().map(|(head, meaning)| [head, meaning].map(String::from)).collect(), rows }
    }

    /// A table whose headings need no explanation.
    pub fn plain<'a>(heads: impl IntoIterator<Item = &'a str>, rows: Vec<Vec<String>>) -> Self {
        Self::new(heads.into_iter().map(|head| (head, "")), rows)
    }

    /// Whether a column holds numbers only.
    pub(super) fn is_numeric(&self, column: usize) -> bool {
        !self.rows.is_empty() && self.rows.iter().all(|row| row.get(column).is_none_or(|cell| numeric(cell)))
    }

    /// The table as lines of text with aligned columns, headings first.
    #[must_use]
    pub fn text(&self) -> String {
        let heads: Vec<&str> = self.columns.iter().map(|[head, _]| head.as_str()).collect();
        let rows = self.rows.iter().map(|row| row.iter().map(String::as_str).collect());
        let lines: Vec<Vec<&str>> = std::iter::once(heads).chain(rows).collect();
        let width = |k: usize| lines.iter().filter_map(|line| line.get(k)).map(|cell| cell.chars().count()).max();
        let format: Vec<(usize, bool)> =
            (0..self.columns.len()).map(|k| (width(k).unwrap_or(0), self.is_numeric(k))).collect();
        let line = |cells: &Vec<&str>| {
            let padded = cells.iter().zip(&format).map(|(cell, &(width, right))| match right {
                true => format!("{cell:>width$}"),
                false => format!("{cell:<width$}"),
            });
            format!("{}\n", padded.collect::<Vec<_>>().join("  ").trim_end())
        };
        lines.iter().map(line).collect()
    }

    /// The table as a CSV file.
    pub fn csv(&self) -> Result<String> {
        // A file with two columns of one name can't be read by name.
        let heads: Vec<&String> = self.columns.iter().map(|[head, _]| head).collect();
        if let Some((_, head)) = heads.iter().enumerate().find(|(k, head)| heads[..*k].contains(head)) {
            return Err(Error::Check(format!("a table to be written as CSV has two columns {head:?}")));
        }
        let lost = |error: &dyn std::fmt::Display| Error::Check(format!("a table could not be written: {error}"));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(heads).map_err(|error| lost(&error))?;
        self.rows.iter().try_for_each(|row| writer.write_record(row)).map_err(|error| lost(&error))?;
        let bytes = writer.into_inner().map_err(|error| lost(&error))?;
        String::from_utf8(bytes).map_err(|error| lost(&error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_aligned_and_csv_is_quoted() {
        let rows = [("a, b", 1.5), ("c", 20.0)];
        let table = Table::of(&rows, &[("what", "", &|r| r.0.into()), ("mm", "its size", &|r| r.1.to_string())]);
        assert_eq!(table.text(), "what   mm\na, b  1.5\nc      20\n");
        assert_eq!(table.csv().unwrap(), "what,mm\n\"a, b\",1.5\nc,20\n");
        let twice = Table::plain(["ms", "ms"], Vec::new());
        assert_eq!(twice.text(), "ms  ms\n");
        assert!(twice.csv().unwrap_err().to_string().contains("two columns \"ms\""));
    }

    #[test]
    fn numbers_are_told_from_names() {
        assert!(["1.5", "-2e-3", "<1e6", "12 ms", "+0.3", "", "-", "\u{b1} 0.1"].into_iter().all(numeric));
        assert!(!["too few", "3 lights of two colours", "x1"].into_iter().any(numeric));
    }
}
