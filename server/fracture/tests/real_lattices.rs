//! Levels of real meshes, from the folder that SHATTER_MESHES names.

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::lattice::{
    CRACK_NODES_DEFAULT, DihedralRange, ELASTIC_NODES_DEFAULT, Lattice, Spacings, check_manifold, default_spacing,
    levels,
};
use shatter_fracture::surface::{InsideTest, LengthUnit, Surface, UpAxis, read};
use std::path::Path;

/// Builds the levels of a mesh with about `nodes` crack nodes, checks their invariants, and prints one row per level.
fn check(file: &str, nodes: usize) {
    let Ok(folder) = std::env::var("SHATTER_MESHES") else {
        println!("skipped: SHATTER_MESHES is not set");
        return;
    };
    let surface = Surface::repair(read(&Path::new(&folder).join(file), LengthUnit::M, UpAxis::Y).unwrap()).unwrap();
    let (inside, token) = (InsideTest::new(&surface), CancelToken::default());
    let volume = inside.input_volume(&token).unwrap();
    let area = |nodes: &[u32; 3]| {
        let [a, b, c] = nodes.map(|node| surface.positions[node as usize]);
        (b - a).cross(&(c - a)).norm() / 2.0
    };
    let area = surface.triangles.iter().map(area).sum();
    let [elastic, crack] = [ELASTIC_NODES_DEFAULT, nodes].map(|nodes| default_spacing(volume, area, nodes));
    let levels =
        levels(&inside, Spacings { elastic, crack, refine: true, fits_elastic: false }, volume, &token).unwrap();
    for body in &levels.bodies {
        check_manifold(&body.elastic).unwrap();
        check_manifold(&body.crack).unwrap();
        let energy: Vec<f64> = (0..body.elastic.tets.len()).map(|tet| body.elastic.tet_volume(tet)).collect();
        let mut nodes = Vec::new();
        body.transfer.apply(&energy, &mut nodes);
        assert!((nodes.iter().sum::<f64>() / energy.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let deviation = |body: &Lattice| body.deviation(&|point| inside.signed_distance(point));
    let deviations = [
        levels.bodies.iter().map(|body| deviation(&body.elastic)).fold(0.0, f64::max),
        levels.bodies.iter().map(|body| deviation(&body.crack)).fold(0.0, f64::max),
    ];
    for (report, deviation) in levels.elastic.iter().chain([&levels.crack]).zip(deviations) {
        let error = report.volume / volume - 1.0;
        let DihedralRange { min_deg, max_deg } = report.dihedral;
        println!(
            "{file} at {:.5}: {} nodes, {} tetrahedra, {min_deg:.1} to {max_deg:.1} degrees, volume {error:+.4}, \
             offset {:+.4}, deviation {deviation:.5}, {} pinches, {} bodies, {} dropped",
            report.spacing,
            report.nodes,
            report.tets,
            report.offset,
            report.pinches_mended,
            report.bodies,
            report.dropped.len(),
        );
        assert!(min_deg > 10.7 && max_deg < 164.8);
        assert!(error.abs() < 2e-3, "volume {error}");
        assert!(deviation < report.spacing, "deviation {deviation}");
    }
    let share = levels.crack.nodes as f64 / nodes as f64;
    assert!((share - 1.0).abs() < 0.1 && levels.bodies.len() == 1, "{share} {:?}", levels.replaced);
}

/// With [`CRACK_NODES_DEFAULT`] a tip separates, and baking refines the spacing; `tests/tests/horse.rs` covers that.
#[test]
fn the_horse_keeps_its_volume_and_legs() {
    check("horse.ply", 10_000);
}

#[test]
fn the_bunny_is_closed_over_its_holes() {
    check("stanford-bunny.obj", CRACK_NODES_DEFAULT);
}
