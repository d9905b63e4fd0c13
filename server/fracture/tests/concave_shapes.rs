//! Purpose of the interior lift: cells of a Voronoi diagram do not join limbs that are close only through empty space.

use nalgebra::Point3;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{DiagramOptions, DiagramWorkspace, EnergyField, diagram};
use shatter_fracture::lattice::{Lattice, block, stuff};
use shatter_fracture::lift::{ALPHA_DEFAULT, LiftedLattice, MODES_DEFAULT, Spectrum, interior, stretch};
use shatter_fracture::surface::{self, InsideTest, LengthUnit, Surface, UpAxis};
use std::path::Path;

/// Starts per number of sites.
const STARTS: u32 = 12;

/// Connected parts of the nodes chosen by `limb`, connected by edges between such nodes; `None` for other nodes.
///
/// Parts of fewer than 20 nodes are not limbs.
fn limbs(lattice: &Lattice, limb: impl Fn(&Point3<f64>) -> bool) -> Vec<Option<usize>> {
    let mut parts: Vec<usize> = (0..lattice.nodes.len()).collect();
    let edges = lattice.edges();
    let mut changed = true;
    while changed {
        changed = false;
        for [a, b] in edges.iter().map(|edge| edge.map(|node| node as usize)) {
            if limb(&lattice.nodes[a]) && limb(&lattice.nodes[b]) && parts[a] != parts[b] {
                let lower = parts[a].min(parts[b]);
                (parts[a], parts[b], changed) = (lower, lower, true);
            }
        }
    }
    let mut sizes = vec![0; lattice.nodes.len()];
    parts.iter().for_each(|&part| sizes[part] += 1);
    let own = |node: usize| (limb(&lattice.nodes[node]) && sizes[parts[node]] >= 20).then_some(parts[node]);
    (0..lattice.nodes.len()).map(own).collect()
}

/// Number of starts of uniform energy in which a cell contains nodes of two limbs.
fn joined(lattice: &Lattice, lift: &LiftedLattice, limbs: &[Option<usize>], sites: usize) -> usize {
    let volumes = lattice.node_volumes();
    let mut mass = volumes.clone();
    let field = EnergyField::new(lift, &volumes, &mut mass).unwrap();
    let mut workspace = DiagramWorkspace::default();
    let joins = |start: &u32| {
        let options = DiagramOptions { start: *start, ..DiagramOptions::new(sites, 5) };
        let diagram = diagram(&field, &options, &mut workspace, &CancelToken::default()).unwrap();
        let mut first = vec![None; diagram.count()];
        limbs.iter().zip(&diagram.labels).any(|(limb, &cell)| {
            let Some(limb) = limb else { return false };
            *first[cell as usize].get_or_insert(limb) != limb
        })
    };
    (0..STARTS).filter(joins).count()
}

/// Expects that the default interior lift joins limbs in at most `interior_max` starts, and X = x in at least
/// `euclidean_min`.
#[track_caller]
fn check(lattice: &Lattice, limbs: &[Option<usize>], sites: usize, euclidean_min: usize, interior_max: usize) {
    let lift = interior(lattice, MODES_DEFAULT, ALPHA_DEFAULT, &CancelToken::default()).unwrap();
    let through_space = joined(lattice, &LiftedLattice::euclidean(lattice), limbs, sites);
    let inside = joined(lattice, &lift, limbs, sites);
    println!("{sites} sites, dimension {}: {inside} starts join limbs, {through_space} with X = x", lift.dimension);
    assert!(through_space >= euclidean_min, "X = x joins limbs in {through_space} of {STARTS} starts");
    assert!(inside <= interior_max, "the interior lift joins limbs in {inside} of {STARTS} starts");
}

#[test]
fn the_teeth_of_a_comb_are_not_joined() {
    // Eight teeth of two cells and slots of one cell, on a back of two rows.
    let spacing = 0.05;
    let solid = |at: &Point3<f64>| ((at.x / spacing + 11.5) / 3.0).fract() * 3.0 < 2.0 || at.y < -0.15;
    let full = block([23, 10, 3], spacing);
    let tets = (0..full.tets.len()).filter(|&tet| {
        let center = full.corners(tet).iter().fold(nalgebra::Vector3::zeros(), |sum, corner| sum + corner.coords) / 4.0;
        solid(&Point3::from(center))
    });
    let comb = compact(&full, &tets.map(|tet| full.tets[tet]).collect::<Vec<_>>());
    let teeth = limbs(&comb, |node| node.y > -0.05);
    check(&comb, &teeth, 20, 10, 2);
    check(&comb, &teeth, 40, 4, 1);
}

#[test]
fn the_lower_legs_of_the_horse_are_not_joined() {
    let Some(folder) = std::env::var_os("SHATTER_MESHES") else {
        println!("SHATTER_MESHES is not set: skipped");
        return;
    };
    let token = CancelToken::default();
    let raw = surface::read(&Path::new(&folder).join("horse.ply"), LengthUnit::M, UpAxis::Z).unwrap();
    let inside = InsideTest::new(&Surface::repair(raw).unwrap());
    let volume = inside.input_volume(&token).unwrap();
    let horse = stuff(&inside, 0.02, Some(volume), &token).unwrap().bodies.swap_remove(0);
    let spectrum = Spectrum::compute(&horse, 24, &token).unwrap();
    println!(
        "{} nodes, residual {:.1e}, eigenvalues {:.1?}",
        horse.nodes.len(),
        spectrum.residual,
        spectrum.eigenvalues
    );
    let lift = spectrum.lift(&horse, MODES_DEFAULT, ALPHA_DEFAULT).unwrap();
    let stretch = stretch(&lift, &horse);
    println!("{stretch:?}");
    assert!(stretch.p99 < 12.0, "{stretch:?}");
    let (low, high) = horse.nodes.iter().fold((f64::MAX, f64::MIN), |span, at| (span.0.min(at.y), span.1.max(at.y)));
    let legs = limbs(&horse, |node| node.y < low + 0.2 * (high - low));
    check(&horse, &legs, 14, 9, 4);
    check(&horse, &legs, 20, 7, 1);
}

/// The lattice of some tetrahedra of another.
fn compact(lattice: &Lattice, tets: &[[u32; 4]]) -> Lattice {
    let mut used: Vec<u32> = tets.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let renumbered = |node: u32| used.partition_point(|&other| other < node) as u32;
    Lattice {
        nodes: used.iter().map(|&node| lattice.nodes[node as usize]).collect(),
        tets: tets.iter().map(|nodes| nodes.map(renumbered)).collect(),
    }
}
