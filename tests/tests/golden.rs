//! Results of this commit compared with those of the golden one (`tests/golden/`).

use shatter_tests::golden::{Results, differences, folder, processor, programs_before, results};
use std::path::Path;

#[track_caller]
fn compare(before: &Results, now: &Results) {
    let found = differences(before, now);
    let refused = before.iter().filter(|(_, document)| !document["error"].is_null());
    refused.for_each(|(request, document)| println!("refused: {request}: {}", document["error"]["message"]));
    println!("{} requests compared, {} values differ", before.len(), found.len());
    for request in before.keys() {
        let own = found.iter().filter(|value| value.starts_with(&format!("{request} > "))).count();
        if own > 0 {
            println!("{own} values differ: {request}");
        }
    }
    let shown: Vec<&String> = found.iter().take(40).collect();
    assert!(found.is_empty() && !before.is_empty(), "{} values differ: {shown:#?}", found.len());
}

fn read(path: &Path) -> Option<Results> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

/// On a processor without a recording, answers that are those of another processor bit by bit will do. Else the golden commit is built and
/// recorded in the target folder: minutes, once.
#[test]
fn ten_results_match_the_golden_commit() {
    let now = results(None, false);
    let name = format!("{}.json", processor());
    let (recordings, own) = (folder().join("recordings"), folder().join("../../target/golden").join(&name));
    if let Some(before) = read(&recordings.join(&name)).or_else(|| read(&own)) {
        return compare(&before, &now);
    }
    let files = std::fs::read_dir(recordings).unwrap().map(|entry| entry.unwrap().path());
    let mut all = files.filter_map(|file| Some((read(&file)?, file)));
    if let Some((before, file)) = all.find(|(before, _)| differences(before, &now).is_empty()) {
        println!("no recording of the processor {}: compared with {}", processor(), file.display());
        return compare(&before, &now);
    }
    println!("no recording of the processor {}: building the golden commit", processor());
    let recorded = results(Some(programs_before()), false);
    std::fs::write(&own, serde_json::to_vec(&recorded).unwrap()).unwrap();
    compare(&recorded, &now);
}

#[test]
#[ignore = "minutes: builds the golden commit"]
fn sixty_results_match_the_golden_commit() {
    let before = results(Some(programs_before()), true);
    compare(&before, &results(None, true));
}

#[test]
fn differences_are_detected() {
    let results = |text: &str| -> Results { serde_json::from_str(text).unwrap() };
    let before = results(r#"{"a": {"x": 1.5, "gone": 1, "rows": [{"y": 1}]}, "b": {}}"#);
    assert_eq!(differences(&before, &before), Vec::<String>::new());
    let now = results(r#"{"a": {"x": 1.5000000000000002, "new": 2, "rows": [{"y": 2}]}}"#);
    let found = differences(&before, &now);
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[0].starts_with("a > rows > 0 > y: 1 before, 2 now") || found[1].starts_with("a > rows"), "{found:?}");
}
