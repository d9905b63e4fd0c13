//! Every compilation of a kernel for wider instructions is listed here, and has a test that compares its bits with the baseline's.

use std::fs;
use std::path::Path;

/// A compilation of a kernel, and the tests that force each compilation that the processor supports.
struct Compiled {
    file: &'static str,
    features: &'static str,
    /// File and name of each test.
    tests: &'static [(&'static str, &'static str)],
}

const CENTROIDAL: &[(&str, &str)] = &[("centroidal/tests/invariance.rs", "wide_instructions_do_not_change_a_bit")];

const KNOWN: [Compiled; 2] = [
    Compiled { file: "centroidal/kernel.rs", features: "avx2", tests: CENTROIDAL },
    Compiled { file: "centroidal/kernel.rs", features: "avx2,avx512f", tests: CENTROIDAL },
];

/// Files that run a kernel through `simd.rs`, which `pulp` compiles for each path, with the file and name of the test that forces all.
const KERNELS: [(&str, (&str, &str)); 10] = [
    ("elasticity/energy.rs", ("elasticity/energy.rs", "wide_and_plain_instructions_give_the_same_bits")),
    (
        "elasticity/quadratic/product.rs",
        ("elasticity/tests/quadratic.rs", "wide_instructions_do_not_change_a_bit_of_a_solution"),
    ),
    ("elasticity/recovery.rs", ("elasticity/tests/recovery.rs", "wide_instructions_do_not_change_a_bit_of_a_recovery")),
    ("elasticity/reduced.rs", ("elasticity/tests/reduced.rs", "wide_instructions_do_not_change_a_bit_of_a_projection")),
    (
        "elasticity/refined/conjugate_gradients.rs",
        ("elasticity/refined/tests.rs", "wide_and_plain_instructions_give_the_same_bits"),
    ),
    ("elasticity/refined/cycle.rs", ("elasticity/refined/tests.rs", "wide_and_plain_instructions_give_the_same_bits")),
    (
        "elasticity/refined/quadratic.rs",
        ("elasticity/refined/tests.rs", "wide_and_plain_instructions_give_the_same_bits"),
    ),
    ("elasticity/row_products.rs", ("elasticity/row_products.rs", "wide_and_plain_instructions_give_the_same_bits")),
    ("fragment/properties.rs", ("fragment/tests.rs", "wide_instructions_do_not_change_a_bit")),
    ("tessellation/points.rs", ("tessellation/tests/layout.rs", "wide_instructions_do_not_change_a_bit")),
];

/// Sources of the engine by their paths below `server/fracture/src`.
fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../server/fracture/src");
    let (mut found, mut open) = (Vec::new(), vec![root.clone()]);
    while let Some(folder) = open.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
                found.push((name, fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn every_compiled_path_has_a_test_that_compares_its_bits() {
    let sources = sources();
    let mut compiled = Vec::new();
    for (name, text) in &sources {
        for line in text.lines() {
            if let Some((_, rest)) = line.split_once("#[target_feature(enable = \"") {
                compiled.push((name.as_str(), rest.split('"').next().unwrap()));
            }
        }
    }
    let mut known: Vec<(&str, &str)> = KNOWN.iter().map(|known| (known.file, known.features)).collect();
    compiled.sort();
    known.sort();
    assert_eq!(compiled, known, "a path that no test forces, or a test of a path that is gone");
    for (file, test) in KNOWN.iter().flat_map(|known| known.tests).chain(KERNELS.iter().map(|(_, test)| test)) {
        let (_, text) = sources.iter().find(|(name, _)| name == file).unwrap_or_else(|| panic!("no file {file}"));
        assert!(text.contains(&format!("fn {test}()")), "{file} has no test {test}");
    }
}

#[test]
fn every_kernel_is_compared_on_all_paths() {
    let sources = sources();
    let calls = |text: &str| text.lines().any(|line| line.contains("widest(") && !line.contains("fn widest"));
    let callers: Vec<&str> =
        sources.iter().filter(|(name, text)| name != "simd.rs" && calls(text)).map(|(name, _)| name.as_str()).collect();
    assert_eq!(callers, KERNELS.map(|(file, _)| file), "a kernel that no test runs on all paths");
}
