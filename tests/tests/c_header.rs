//! The header of the C interface equals the output of cbindgen for its source.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../client/c").join(name)
}

/// Files of the source in the order of the header, without tests.
fn sources() -> Vec<PathBuf> {
    let order = ["code", "error", "service", "host", "facts", "object", "impact", "ticket", "result", "result_rows"];
    let files = order.map(|name| here("src").join(name).with_extension("rs"));
    let lib = std::fs::read_to_string(here("src/lib.rs")).unwrap();
    let modules = lib.lines().filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'));
    let known: BTreeSet<&str> = order.into_iter().chain(["ffi_boundary"]).collect();
    assert_eq!(modules.collect::<BTreeSet<_>>(), known, "every file with something public goes into the header");
    files.to_vec()
}

fn header() -> String {
    let config = cbindgen::Config::from_file(here("cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_config(config);
    let bindings = sources().into_iter().fold(builder, cbindgen::Builder::with_src).generate().unwrap();
    let mut text = Vec::new();
    bindings.write(&mut text);
    String::from_utf8(text).unwrap()
}

#[test]
fn the_header_is_that_of_the_source() {
    let (path, made) = (here("../include/shatter.h"), header());
    if std::env::var_os("SHATTER_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap();
    let differs = there.lines().zip(made.lines()).position(|(a, b)| a != b);
    assert!(
        there == made,
        "{} is not up to date from line {:?} on: SHATTER_WRITE_HEADER=1 cargo test --release --workspace --test suite c_header::",
        path.display(),
        differs.map(|line| line + 1)
    );
}

/// Everything that the library exports is declared, under a name with its prefix.
#[test]
fn every_function_is_declared_once() {
    let made = header();
    let mut functions = 0;
    for file in sources() {
        let text = std::fs::read_to_string(&file).unwrap();
        for line in text.lines().filter(|line| line.contains("extern \"C\" fn ")) {
            let name = line.split("fn ").nth(1).unwrap().split('(').next().unwrap();
            assert!(name.starts_with("shatter_"), "{name}");
            assert_eq!(made.matches(&format!("{name}(")).count(), 1 + usize::from(in_the_preamble(name)), "{name}");
            functions += 1;
        }
    }
    assert!(functions > 25, "{functions}");
    for kind in shatter_client::ErrorKind::ALL {
        let code = format!("SHATTER_CODE_{} = {},", kind.name().to_uppercase(), kind.code());
        assert!(made.contains(&code), "{code}");
    }
}

/// True if the example in the preamble of the header uses the function.
fn in_the_preamble(name: &str) -> bool {
    let text = std::fs::read_to_string(here("cbindgen.toml")).unwrap();
    text.contains(&format!("{name}("))
}
