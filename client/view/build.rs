//! Copies the page that `npm run build` made to where the sources include it, if the feature `page` is on.

use std::path::Path;
use std::process::ExitCode;

/// Files of the page.
const FILES: [&str; 4] = ["index.html", "view.js", "view.css", "licenses.txt"];

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_PAGE").is_none() {
        return ExitCode::SUCCESS;
    }
    let (Some(root), Some(out)) = (std::env::var_os("CARGO_MANIFEST_DIR"), std::env::var_os("OUT_DIR")) else {
        println!("cargo::error=build.rs runs under cargo alone");
        return ExitCode::FAILURE;
    };
    for name in FILES {
        let file = Path::new(&root).join("dist").join(name);
        println!("cargo::rerun-if-changed={}", file.display());
        if let Err(error) = std::fs::copy(&file, Path::new(&out).join(name)) {
            println!(
                "cargo::error=the page is not built: {}: {error}. Build it first: (cd client/view && npm ci && npm run build)",
                file.display()
            );
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
