//! The page of a study: sections of words, plots and tables.

use super::text::escape;
use super::{Fact, ReportFigure, facts, figure, shell};

/// A table; the first column names the row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportTable {
    /// Headings.
    pub head: Vec<String>,
    /// Rows with their class for the style sheet: "", "passed", "refused" or "failed".
    pub rows: Vec<(&'static str, Vec<String>)>,
}

/// One part of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its heading.
    pub heading: String,
    /// Paragraphs.
    pub lead: Vec<String>,
    /// SVG documents made by us, each with its caption.
    pub plots: Vec<(String, String)>,
    /// Pictures.
    pub figures: Vec<ReportFigure>,
    /// Tables.
    pub tables: Vec<ReportTable>,
}

/// A whole study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// Title.
    pub title: String,
    /// What was done, a paragraph each.
    pub lead: Vec<String>,
    /// The outcome in figures.
    pub facts: Vec<Fact>,
    /// Its parts.
    pub sections: Vec<Section>,
}

/// The study as one HTML document.
pub fn study(page: &Study) -> String {
    let sections: String = page.sections.iter().enumerate().map(|(number, part)| section(number, part)).collect();
    shell(&page.title, "", &page.lead, &facts(&page.facts), &sections)
}

fn section(number: usize, part: &Section) -> String {
    let lead: String = part.lead.iter().map(|line| format!("<p>{}</p>\n", escape(line))).collect();
    let plots: String = part
        .plots
        .iter()
        .map(|(svg, caption)| {
            format!("<figure class=\"plot\">\n{svg}\n<figcaption>{}</figcaption>\n</figure>\n", escape(caption))
        })
        .collect();
    let figures: String =
        part.figures.iter().enumerate().map(|(k, shown)| figure(&format!("ramp-{number}-{k}"), shown)).collect();
    let tables: String = part.tables.iter().map(table).collect();
    format!(
        "<section>\n<h2>{}</h2>\n{lead}<div class=\"figures\">\n{plots}{figures}</div>\n{tables}</section>\n",
        escape(&part.heading)
    )
}

fn table(table: &ReportTable) -> String {
    let cells = |tag: &str, cells: &[String]| -> String {
        cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect()
    };
    let rows: String =
        table.rows.iter().map(|(class, row)| format!("<tr class=\"{class}\">{}</tr>\n", cells("td", row))).collect();
    format!(
        "<div class=\"scroll\"><table class=\"figures-table\">\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        cells("th", &table.head)
    )
}
