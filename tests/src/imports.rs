//! Imports between the files of a crate, from their `use` declarations; re-exports are followed to the file that defines the name.

use crate::sources::{code, shipped};
use std::collections::{BTreeMap, BTreeSet};

/// Files below one folder of sources, by the path of their module (`a::b`; the root is empty).
pub struct Imports {
    /// File and imported paths of each module.
    modules: BTreeMap<String, Module>,
}

struct Module {
    file: String,
    imports: Vec<Vec<String>>,
    /// Names that the module re-exports, with their paths.
    exports: BTreeMap<String, Vec<String>>,
}

impl Imports {
    /// Reads the imports of the files of `sources` below `folder` (`server/src`), without tests.
    pub fn of(folder: &str, sources: &[(String, String)]) -> Self {
        let mut texts = BTreeMap::new();
        for (name, text) in sources {
            let Some(file) = name.strip_prefix(&format!("{folder}/")) else { continue };
            let lines = shipped(name, text);
            let text: Vec<&str> = lines.iter().map(|(_, line)| code(line)).collect();
            if !text.is_empty() && file != "main.rs" {
                texts.insert(module_of(file), (file.to_owned(), text.join("\n")));
            }
        }
        let known: BTreeSet<String> = texts.keys().cloned().collect();
        let modules = texts.into_iter().map(|(module, (file, text))| {
            let (mut imports, mut exports) = (Vec::new(), BTreeMap::new());
            for (is_public, tree) in declarations(&text) {
                for path in expand(&tree).iter().filter_map(|path| absolute(&module, path, &known)) {
                    match is_public {
                        true => drop(exports.insert(path.last().cloned().unwrap_or_default(), path)),
                        false => imports.push(path),
                    }
                }
            }
            (module, Module { file, imports, exports })
        });
        Self { modules: modules.collect() }
    }

    /// Sets of more than `most` files that import each other in a cycle.
    pub fn cycles(&self, most: usize) -> Vec<Vec<&str>> {
        let next = |module: &Module| -> BTreeSet<&str> {
            module.imports.iter().filter_map(|path| self.file(path, 0)).filter(|file| *file != module.file).collect()
        };
        let edges: BTreeMap<&str, BTreeSet<&str>> =
            self.modules.values().map(|module| (module.file.as_str(), next(module))).collect();
        let reach = |from: &str| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![from.to_owned()]);
            while let Some(file) = open.pop() {
                for next in edges.get(file.as_str()).into_iter().flatten() {
                    if seen.insert((*next).to_owned()) {
                        open.push((*next).to_owned());
                    }
                }
            }
            seen
        };
        let reached: BTreeMap<&str, BTreeSet<String>> = edges.keys().map(|file| (*file, reach(file))).collect();
        let mut cycles: BTreeSet<Vec<&str>> = BTreeSet::new();
        for file in edges.keys().filter(|file| reached[*file].contains(**file)) {
            let both = |other: &&&str| reached[*file].contains(**other) && reached[**other].contains(*file);
            cycles.insert(edges.keys().filter(both).copied().collect());
        }
        cycles.into_iter().filter(|cycle| cycle.len() > most).collect()
    }

    /// File that defines the item at `path`.
    fn file(&self, path: &[String], depth: usize) -> Option<&str> {
        let longest = (0..=path.len()).rev().find_map(|length| {
            let module = self.modules.get(&path[..length].join("::"))?;
            Some((module, &path[length..]))
        });
        let (module, rest) = longest?;
        match rest.first().and_then(|name| module.exports.get(name)).filter(|_| depth < 8) {
            Some(exported) => self.file(&[exported, &rest[1..]].concat(), depth + 1),
            None => Some(&module.file),
        }
    }
}

fn module_of(file: &str) -> String {
    let path = file.trim_end_matches(".rs").replace('/', "::");
    let path = path.strip_suffix("::mod").unwrap_or(&path);
    if path == "lib" { String::new() } else { path.to_owned() }
}

/// The `use` declarations of a file; true marks the public ones.
fn declarations(text: &str) -> Vec<(bool, String)> {
    let items = text.split(';').filter_map(|item| {
        let line = item.rfind("\nuse ").map(|at| at + 1).or_else(|| item.starts_with("use ").then_some(0));
        let public = item.rfind("\npub").map(|at| at + 1).or_else(|| item.starts_with("pub").then_some(0));
        match (line, public.and_then(|at| Some((at, item[at..].find("use ")?)))) {
            (Some(at), _) => Some((false, item[at + 4..].to_owned())),
            (None, Some((at, offset))) if !item[at..at + offset].contains(['{', '=']) => {
                Some((true, item[at + offset + 4..].to_owned()))
            }
            _ => None,
        }
    });
    items.collect()
}

/// Paths of a `use` tree: `a::{b, c::{d}}` is `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let tree: String = tree.split_whitespace().collect::<Vec<_>>().join(" ");
    let Some((before, inner)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or("").trim().to_owned()];
    };
    let inner = inner.trim_end().strip_suffix('}').unwrap_or(inner);
    let (mut parts, mut depth, mut part) = (Vec::new(), 0, String::new());
    for letter in inner.chars() {
        match letter {
            ',' if depth == 0 => parts.push(std::mem::take(&mut part)),
            _ => {
                depth += i32::from(letter == '{') - i32::from(letter == '}');
                part.push(letter);
            }
        }
    }
    parts.push(part);
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    parts.flat_map(|part| expand(&format!("{}{part}", before.trim()))).collect()
}

/// `path` as `module` writes it, from the root of the crate; `None` for other crates.
fn absolute(module: &str, path: &str, known: &BTreeSet<String>) -> Option<Vec<String>> {
    let mut parts: Vec<String> = path.split("::").map(|part| part.trim().to_owned()).collect();
    let mut base: Vec<String> = module.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
    match parts[0].as_str() {
        "crate" => {
            base.clear();
            parts.remove(0);
        }
        "self" => drop(parts.remove(0)),
        "super" => {
            while parts.first().is_some_and(|part| part == "super") {
                base.pop();
                parts.remove(0);
            }
        }
        first => {
            let child = [base.as_slice(), &[first.to_owned()]].concat().join("::");
            known.contains(&child).then_some(())?;
        }
    }
    if parts.last().is_some_and(|part| part == "self") {
        parts.pop();
    }
    Some([base, parts].concat())
}
