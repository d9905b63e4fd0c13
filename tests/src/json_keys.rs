//! Keys of the JSON documents of `shatter`, and the page of the guide that lists them.

use crate::pages;
use serde_json::Value;
use std::collections::BTreeSet;

/// Keys that the part `title` of the guide's page lists.
pub fn documented(title: &str) -> BTreeSet<String> {
    let page = pages::text(&format!("{}/reference/json.md", pages::GUIDE));
    let (_, part) = page.split_once(&format!("\n## {title}\n")).unwrap();
    let part = part.split("\n## ").next().unwrap();
    let cells = part.lines().filter_map(|line| line.strip_prefix("| `")?.split(" | ").next());
    cells.flat_map(|cell| cell.trim_end_matches('`').split("`, `")).map(str::to_owned).collect()
}

/// Paths of all values in `document` that are no tables; `[]` stands for the elements of a list, `*` for the name of a stage.
pub fn printed(document: &Value) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    collect("", document, &mut found);
    found
}

fn collect(path: &str, value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(table) if path != "objects[].error" => {
            for (key, value) in table {
                let key = if path == "stages" { "*" } else { key };
                collect(&if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }, value, found);
            }
        }
        Value::Array(list) if list.iter().any(Value::is_object) => {
            list.iter().for_each(|value| collect(&format!("{path}[]"), value, found));
        }
        _ => {
            found.insert(path.to_owned());
        }
    }
}

/// Checks that the part `title` of the page lists the keys of `documents`, and no others. A list without elements and a value that is `null`
/// in one of them hide the keys below.
///
/// # Panics
/// If it does not.
pub fn check(title: &str, documents: &[&Value]) {
    let listed = documented(title);
    let printed: BTreeSet<String> = documents.iter().flat_map(|document| printed(document)).collect();
    let below = |key: &str, other: &str| other.strip_prefix(key).is_some_and(|rest| rest.starts_with(['.', '[']));
    let unlisted = printed.iter().filter(|key| !listed.contains(*key) && !listed.iter().any(|other| below(key, other)));
    let unlisted: Vec<&String> = unlisted.collect();
    let unprinted = listed.difference(&printed).filter(|key| !printed.iter().any(|other| below(other, key)));
    let unprinted: Vec<&String> = unprinted.collect();
    assert!(unlisted.is_empty(), "{title}: the page lacks {unlisted:?}");
    assert!(unprinted.is_empty(), "{title}: not printed: {unprinted:?}");
}
