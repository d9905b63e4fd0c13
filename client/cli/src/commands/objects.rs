//! Output about objects that `list` and `status` share.

use super::time_of_day::utc;
use serde_json::{Map, Value, json};
use shatter_client::ObjectFacts;
use shatter_proto::text::escaped;

const MIB: f64 = 1_048_576.0;

/// Document of an object: its name and state, the error if it or its changed file could not be loaded, and `facts` if it can be struck.
pub fn document(object: &ObjectFacts, facts: Value) -> Value {
    let mut document = Map::from_iter([
        ("object".to_owned(), json!(object.name)),
        ("ready".to_owned(), json!(object.is_ready())),
        ("state".to_owned(), json!(object.state.name())),
    ]);
    if let Some(error) = &object.error {
        document.insert("error".to_owned(), error.document()["error"].clone());
    }
    if let (true, Value::Object(facts)) = (object.is_ready(), facts) {
        document.extend(facts);
    }
    Value::Object(document)
}

/// Document of a loaded database: time of loading, memory, size.
pub fn loaded(object: &ObjectFacts) -> Value {
    let facts = json!({
        "generation": object.generation,
        "memory_bytes": object.memory_bytes,
        "file_bytes": object.file_bytes,
        "loaded_unix_s": object.loaded_unix.as_secs_f64(),
        "load_s": object.load_time.as_secs_f64(),
    });
    document(object, facts)
}

/// Width of the column of names, characters.
pub fn width(objects: &[ObjectFacts]) -> usize {
    objects.iter().map(|object| escaped(&object.name).chars().count()).max().unwrap_or(0).max(6)
}

/// Line of the error of an object that, or whose changed file, could not be loaded; empty if there is no error.
pub fn failure_message(object: &ObjectFacts, width: usize) -> String {
    match &object.error {
        Some(error) if object.is_ready() => format!("{:width$}  outdated: {error}\n", ""),
        Some(error) => format!("{:width$}  {:7}  {error}\n", escaped(&object.name), object.state.name()),
        None => String::new(),
    }
}

/// Table of [`loaded`], for people.
pub fn table(objects: &[ObjectFacts]) -> String {
    let width = width(objects);
    let mut text = format!(
        "{:width$}  {:>10}  {:>8}  {:>7}  {:>7}  loaded\n",
        "object", "memory MiB", "file MiB", "load ms", "version"
    );
    for object in objects {
        if object.is_ready() {
            text += &format!(
                "{:width$}  {:10.1}  {:8.1}  {:7.0}  {:7}  {}\n",
                escaped(&object.name),
                object.memory_bytes as f64 / MIB,
                object.file_bytes as f64 / MIB,
                object.load_time.as_secs_f64() * 1e3,
                object.generation,
                utc(object.loaded_unix)
            );
        }
        text += &failure_message(object, width);
    }
    text
}
