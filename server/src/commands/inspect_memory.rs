//! `shatterd inspect --memory`: memory of a served object, by part.

use super::CommandError;
use crate::memory::{ResidentMemory, release_free};
use serde_json::{Value, json};
use shatter_engine::object::ServedObject;
use shatter_engine::wire::EngineObject;

/// Finishes the object as a daemon does, and compares its memory with the resident memory of this process.
///
/// `before` is the resident memory before the object was loaded.
///
/// # Errors
/// Those of the factorization and of the strikes that the daemon times.
pub fn memory_table(served: &EngineObject, before: Option<ResidentMemory>) -> Result<Value, CommandError> {
    served.finish()?;
    rayon::broadcast(|_| release_free());
    release_free();
    let prepared = served.prepared();
    let mut rows: Vec<(&str, u64)> = prepared.memory().iter().map(|(name, bytes)| (name, bytes as u64)).collect();
    let object_bytes: u64 = rows.iter().map(|(_, bytes)| bytes).sum();
    rows.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    rows.retain(|(_, bytes)| *bytes > 0);
    let now = ResidentMemory::now();
    rows.push(("program and libraries", now.map_or(0, |now| now.file)));
    rows.push(("program's own heap and stacks", before.map_or(0, |before| before.anonymous)));
    let accounted_bytes: u64 = rows.iter().map(|(_, bytes)| bytes).sum();
    let per_node = |bytes: u64| bytes as f64 / prepared.crack_nodes().max(1) as f64;
    let savings = [
        ("bake with --factor f32, if it is accurate enough", prepared.single_precision_saving() as u64),
        ("bake with --surface lattice", prepared.exact_surface_bytes() as u64),
    ];
    let largest = savings.into_iter().filter(|(_, bytes)| *bytes > 0).max_by_key(|(_, bytes)| *bytes);
    let next = largest.map(|(what, bytes)| json!({ "what": what, "bytes": bytes }));
    Ok(json!({
        "rows": rows.iter().map(|(name, bytes)| json!({ "name": name, "bytes": bytes })).collect::<Vec<_>>(),
        "object_bytes": object_bytes,
        "accounted_bytes": accounted_bytes,
        "resident_bytes": now.map(|now| now.total()),
        "object_bytes_per_crack_node": per_node(object_bytes),
        "next_saving": next,
    }))
}

/// Table for people; empty if there is no memory report.
pub fn memory_lines(memory: &Value) -> String {
    let megabytes =
        |value: &Value| value.as_u64().map_or_else(|| "–".to_owned(), |bytes| format!("{:.1} MB", bytes as f64 / 1e6));
    let line = |name: &str, value: &Value| format!("memory: {name:<42} {:>12}\n", megabytes(value));
    let Some(rows) = memory["rows"].as_array() else { return String::new() };
    let mut text: String = rows.iter().map(|row| line(row["name"].as_str().unwrap_or(""), &row["bytes"])).collect();
    text += &line("sum of these rows", &memory["accounted_bytes"]);
    text += &line("resident in this process", &memory["resident_bytes"]);
    if let Some(what) = memory["next_saving"]["what"].as_str() {
        text += &line(&format!("next saving: {what}"), &memory["next_saving"]["bytes"]);
    }
    text
}
