//! The page that shows what a run did: one HTML file with its pictures inside, nothing fetched from anywhere.
//!
//! Everything that is shown comes in as plain text and is escaped here; pictures become data addresses. The page follows
//! the reader's light or dark setting and reads on a phone.

mod chart;
mod figures;
mod study;
mod text;

pub use figures::{bytes, grouped, nanoseconds, share, significant};
pub use study::{ReportTable, Section, Study, study};

use crate::picture::Ramp;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use text::{escape, path};

/// A labelled figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    /// What it is.
    pub label: String,
    /// Its value with unit.
    pub value: String,
}

impl Fact {
    /// A fact from anything that reads as text.
    pub fn new(label: impl Into<String>, value: impl Into<String>) -> Self {
        Self { label: label.into(), value: value.into() }
    }
}

/// A picture with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportFigure {
    /// Bytes of a PNG file.
    pub png: Vec<u8>,
    /// What it shows, for those who see it and those who do not.
    pub caption: String,
    /// Colors and figures of the picture, if colors mean figures in it.
    pub scale: Option<Scale>,
}

/// What the colors of a picture mean: a ramp over the decades from `low` to `high`.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The color map; pale is `low`.
    pub ramp: Ramp,
    /// Value of the first color, positive.
    pub low: f64,
    /// Value of the last color, above `low`.
    pub high: f64,
    /// What is measured, with its unit.
    pub label: String,
}

/// How long a stage took.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StageTime {
    /// Its name.
    pub name: String,
    /// Nanoseconds; `None`: it did not run.
    pub ns: Option<u64>,
}

/// One strike.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeReport {
    /// Its heading.
    pub heading: String,
    /// A sentence on it.
    pub lead: String,
    /// Pictures, side by side where there is room.
    pub figures: Vec<ReportFigure>,
    /// Figures in words.
    pub facts: Vec<Fact>,
    /// One bar each.
    pub stages: Vec<StageTime>,
    /// Name of the file with the fragments, in the page's own folder.
    pub file: Option<String>,
}

/// A whole page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Title.
    pub title: String,
    /// Pictures that come first, side by side where there is room.
    pub opening: Vec<ReportFigure>,
    /// What was done, a paragraph each.
    pub lead: Vec<String>,
    /// The strikes in order.
    pub strikes: Vec<StrikeReport>,
    /// The object and the run.
    pub facts: Vec<Fact>,
    /// Remarks at the end: what the figures mean and where they come from.
    pub notes: Vec<String>,
}

/// The page as one HTML document.
pub fn html(page: &Page) -> String {
    let longest = page.strikes.iter().flat_map(|strike| &strike.stages).filter_map(|stage| stage.ns).max().unwrap_or(0);
    let strikes: String = page.strikes.iter().enumerate().map(|(k, strike)| section(k, strike, longest)).collect();
    let notes =
        if page.notes.is_empty() { String::new() } else { format!("<footer>\n{}</footer>\n", paragraphs(&page.notes)) };
    let ground = match page.facts.is_empty() {
        true => String::new(),
        false => format!("<section>\n<h2>The object</h2>\n{}</section>\n", facts(&page.facts)),
    };
    shell(&page.title, &figures("opening", &page.opening), &page.lead, "", &(strikes + &ground + &notes))
}

/// Pictures side by side; nothing of none. `id` tells their legends apart from those of other places.
fn figures(id: &str, shown: &[ReportFigure]) -> String {
    if shown.is_empty() {
        return String::new();
    }
    let all: String = shown.iter().enumerate().map(|(k, shown)| figure(&format!("ramp-{id}-{k}"), shown)).collect();
    format!("<div class=\"figures {id}\">\n{all}</div>\n")
}

fn paragraphs(lines: &[String]) -> String {
    lines.iter().map(|line| format!("<p>{}</p>\n", escape(line))).collect()
}

/// The document around `body`; `opening`, `facts` and `body` are HTML already.
fn shell(title: &str, opening: &str, lead: &[String], facts: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n\
         <body>\n<main>\n<header>\n<h1>{title}</h1>\n{opening}{lead}{facts}</header>\n{body}</main>\n</body>\n</html>\n",
        title = escape(title),
        style = include_str!("style.css"),
        lead = paragraphs(lead),
    )
}

fn section(number: usize, strike: &StrikeReport, longest: u64) -> String {
    let figures = figures(&format!("strike-{number}"), &strike.figures);
    let file = strike.file.as_ref().map_or_else(String::new, |name| {
        format!("<p class=\"file\"><a href=\"{}\" download>{}</a></p>\n", path(name), escape(name))
    });
    format!(
        "<section>\n<h2>{heading}</h2>\n<p>{lead}</p>\n{figures}\
         <div class=\"columns\">\n<div>\n{facts}{file}</div>\n{chart}</div>\n</section>\n",
        heading = escape(&strike.heading),
        lead = escape(&strike.lead),
        facts = facts(&strike.facts),
        chart = chart::stages(&strike.stages, longest),
    )
}

fn figure(id: &str, shown: &ReportFigure) -> String {
    let caption = escape(&shown.caption);
    let legend = shown.scale.as_ref().map_or_else(String::new, |scale| chart::legend(id, scale));
    format!(
        "<figure>\n<img alt=\"{caption}\" src=\"data:image/png;base64,{}\">\n{legend}<figcaption>{caption}</figcaption>\n</figure>\n",
        STANDARD.encode(&shown.png)
    )
}

fn facts(facts: &[Fact]) -> String {
    if facts.is_empty() {
        return String::new();
    }
    let rows: String = facts
        .iter()
        .map(|fact| format!("<div><dt>{}</dt><dd>{}</dd></div>\n", escape(&fact.label), escape(&fact.value)))
        .collect();
    format!("<dl>\n{rows}</dl>\n")
}

#[cfg(test)]
mod tests;
