//! Tests of the generated page.

use super::*;
use crate::picture::ENERGY;

const NASTY: &str = "<script>alert(\"x\")</script> & 'co'";

fn strike(ns: u64) -> ImpactReport {
    let scale = Scale { ramp: ENERGY, low: 0.5, high: 2.0e3, label: format!("J/m³ {NASTY}") };
    ImpactReport {
        heading: NASTY.to_owned(),
        lead: NASTY.to_owned(),
        figures: vec![ReportFigure { png: vec![0, 255, 7], caption: NASTY.to_owned(), scale: Some(scale) }],
        facts: vec![Fact::new(NASTY, NASTY)],
        stages: vec![
            StageTime { name: NASTY.to_owned(), ns: Some(ns) },
            StageTime { name: "degree".to_owned(), ns: None },
        ],
        file: Some("a b\"<ä>.glb".to_owned()),
    }
}

fn page() -> Page {
    let text = || vec![NASTY.to_owned()];
    Page {
        title: NASTY.to_owned(),
        opening: vec![ReportFigure { png: vec![1, 2, 3], caption: "the pieces".to_owned(), scale: None }],
        lead: text(),
        strikes: vec![strike(1_500), strike(3_000)],
        facts: vec![Fact::new("diagonal", "0.17 m")],
        notes: text(),
    }
}

#[test]
fn nothing_from_outside_reads_as_markup() {
    let html = html(&page());
    assert!(!html.contains("<script") && !html.contains("'co'") && !html.contains("alert(\""));
    assert!(html.contains("&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt; &amp; &#39;co&#39;"));
    assert!(html.contains("href=\"./a%20b%22%3C%C3%A4%3E.glb\""));
}

#[test]
fn pictures_come_before_words_and_figures_of_the_object_last() {
    let html = html(&page());
    let place = |text: &str| html.find(text).unwrap();
    let order = ["</h1>", "the pieces", "<header>", "<h2>", "diagonal", "<footer>"].map(place);
    assert!(order[0] < order[1] && order[1] < order[3] && order[3] < order[4] && order[4] < order[5], "{order:?}");
    assert!(order[1] < place("<p>"), "the picture stands before the first paragraph");
}

#[test]
fn nothing_is_fetched() {
    let html = html(&page());
    assert!(html.contains("src=\"data:image/png;base64,AP8H\""));
    for far in ["http:", "https:", "//", "@import", "url(h"] {
        let found = html.replace("image/png", "").contains(far);
        assert!(!found, "{far}");
    }
}

#[test]
fn every_element_that_opens_closes() {
    let html = html(&page());
    let names = [
        "html", "head", "style", "body", "main", "header", "section", "div", "figure", "svg", "table", "tr", "td",
        "dl", "p", "span",
    ];
    for name in names {
        let opened = html.matches(&format!("<{name}>")).count() + html.matches(&format!("<{name} ")).count();
        assert_eq!(opened, html.matches(&format!("</{name}>")).count(), "{name}");
    }
}

#[test]
fn bars_share_one_scale_and_name_what_did_not_run() {
    let html = html(&page());
    assert!(
        html.contains("<rect width=\"50.00\" height=\"10\"/>")
            && html.contains("<rect width=\"100.00\" height=\"10\"/>")
    );
    assert_eq!(html.matches("did not run").count(), 2);
    assert!(html.contains("1.50 µs") && html.contains("1\u{202f}500 ns"));
}

#[test]
fn ticks_stand_at_powers_of_ten() {
    let html = html(&page());
    for label in ["1", "10", "100", "10³"] {
        assert!(html.contains(&format!("%\">{label}</span>")), "{label}");
    }
}

#[test]
fn figures_read_well() {
    assert_eq!(significant(1234.5678, 3), "1235");
    assert_eq!(significant(0.012345, 3), "0.0123");
    assert_eq!(significant(1.5e-7, 2), "1.5\u{a0}×\u{a0}10⁻⁷");
    assert_eq!(significant(-2.5e12, 2), "-2.5\u{a0}×\u{a0}10¹²");
    assert_eq!((significant(0.0, 3), significant(0.999_96, 3)), ("0".to_owned(), "1.00".to_owned()));
    assert_eq!((grouped(1_234_567), grouped(999)), ("1\u{202f}234\u{202f}567".to_owned(), "999".to_owned()));
    assert_eq!((nanoseconds(999), nanoseconds(12_345_678)), ("999 ns".to_owned(), "12.3 ms".to_owned()));
    assert_eq!(
        (bytes(512), bytes(1_572_864), share(0.0125)),
        ("512 B".to_owned(), "1.50 MiB".to_owned(), "1.25 %".to_owned())
    );
}
