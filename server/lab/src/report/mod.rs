//! HTML report of a run: one file with embedded pictures, which loads nothing.
//!
//! All contents come in as plain text and are escaped here; pictures become data URLs. The page follows the reader's light or dark
//! setting and is readable on a phone.

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

/// Labeled value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    /// Label.
    pub label: String,
    /// Value with unit.
    pub value: String,
}

impl Fact {
    /// Creates a fact.
    pub fn new(label: impl Into<String>, value: impl Into<String>) -> Self {
        Self { label: label.into(), value: value.into() }
    }
}

/// Picture with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportFigure {
    /// Bytes of a PNG file.
    pub png: Vec<u8>,
    /// Caption, which is also the alternative text.
    pub caption: String,
    /// Scale of the picture, if its colors represent values.
    pub scale: Option<Scale>,
}

/// Meaning of the colors of a picture: a ramp over the decades from `low` to `high`.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// Color map; pale is `low`.
    pub ramp: Ramp,
    /// Value of the first color, positive.
    pub low: f64,
    /// Value of the last color, above `low`.
    pub high: f64,
    /// Measured quantity with its unit.
    pub label: String,
}

/// Time of a stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StageTime {
    /// Name of the stage.
    pub name: String,
    /// Time, ns; `None`: it did not run.
    pub ns: Option<u64>,
}

/// Report of one request.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactReport {
    /// Heading.
    pub heading: String,
    /// Introductory sentence.
    pub lead: String,
    /// Pictures, side by side on wide screens.
    pub figures: Vec<ReportFigure>,
    /// Labeled values.
    pub facts: Vec<Fact>,
    /// Times of the stages.
    pub stages: Vec<StageTime>,
    /// Name of the file with the fragments, in the folder of the page.
    pub file: Option<String>,
}

/// Contents of a page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Title.
    pub title: String,
    /// Pictures at the top, side by side on wide screens.
    pub opening: Vec<ReportFigure>,
    /// Introduction, by paragraph.
    pub lead: Vec<String>,
    /// Requests in order.
    pub strikes: Vec<ImpactReport>,
    /// Facts on the object and the run.
    pub facts: Vec<Fact>,
    /// Remarks at the end: meaning and source of the values.
    pub notes: Vec<String>,
}

/// Page as one HTML document.
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

/// Pictures side by side; empty without pictures. `id` keeps their legends distinct within the page.
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

/// Document around `body`; `opening`, `facts` and `body` are HTML.
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

fn section(number: usize, strike: &ImpactReport, longest: u64) -> String {
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
