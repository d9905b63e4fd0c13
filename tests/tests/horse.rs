//! The horse: what the method promises, on a real and awkward mesh (97k triangles, all facing inward).

use nalgebra::{Point3, Vector3};
use shatter_fracture::centroidal::Diagram;
use shatter_fracture::lattice::Lattice;
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{DegreeRequest, DegreeSource, Prepared};
use shatter_tests::statistics::{median, rank_correlation};
use shatter_tests::{real, struck};
use std::sync::OnceLock;

/// The horse stands along +z in its file; below this share of its height are the lower legs.
const LOWER_LEGS: f64 = 0.25;

fn horse() -> Option<&'static Prepared> {
    static HORSE: OnceLock<Option<Prepared>> = OnceLock::new();
    HORSE.get_or_init(|| real::baked("horse.ply")).as_ref()
}

/// Head and croup, as fractions of the box of the file; impacts go towards the centre.
const HEAD: [f64; 3] = [0.35, 0.95, 0.85];
const CROUP: [f64; 3] = [0.65, 0.1, 0.75];

/// Lower leg of each node below `height` (local z): connected components of the lattice there; −1 elsewhere.
fn lower_legs(lattice: &Lattice, height: f64) -> Vec<i32> {
    let low = |node: u32| lattice.nodes[node as usize].z < height;
    let edges: Vec<[u32; 2]> = lattice.edges().into_iter().filter(|edge| edge.iter().all(|&node| low(node))).collect();
    let mut root: Vec<u32> = (0..lattice.nodes.len() as u32).collect();
    fn find(root: &mut [u32], mut node: u32) -> u32 {
        while root[node as usize] != node {
            root[node as usize] = root[root[node as usize] as usize];
            node = root[node as usize];
        }
        node
    }
    for [a, b] in edges {
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        root[a.max(b) as usize] = a.min(b);
    }
    let mut legs = vec![-1; root.len()];
    let mut names = std::collections::BTreeMap::new();
    for node in 0..root.len() as u32 {
        if low(node) {
            let count = names.len() as i32;
            legs[node as usize] = *names.entry(find(&mut root, node)).or_insert(count);
        }
    }
    legs
}

/// Cells that hold nodes of two lower legs.
fn joining_cells(diagram: &Diagram, legs: &[i32]) -> usize {
    let mut seen = vec![-1; diagram.cell_energy.len()];
    let mut joins = vec![false; seen.len()];
    for (&label, &leg) in diagram.labels.iter().zip(legs).filter(|(_, leg)| **leg >= 0) {
        let known = &mut seen[label as usize];
        joins[label as usize] |= *known >= 0 && *known != leg;
        *known = leg;
    }
    joins.iter().filter(|&&join| join).count()
}

#[test]
fn it_bakes_within_the_published_bounds() {
    for file in ["horse.ply", "stanford-bunny.obj"] {
        let Some(prepared) = real::baked(file) else { continue };
        let report = &prepared.report;
        println!(
            "{file}: {} elastic and {} crack nodes, volume error {:+.3} %, deviation {:.5} against a spacing of {:.5}, {} bodies",
            prepared.elastic_nodes(),
            prepared.crack_nodes(),
            100.0 * report.volume_error(),
            report.surface_deviation,
            prepared.parameters.crack_spacing,
            prepared.bodies.len(),
        );
        assert!(report.volume_error().abs() <= 0.015);
        assert!(report.surface_deviation <= prepared.parameters.crack_spacing);
    }
}

#[test]
fn interior_distances_keep_the_legs_apart() {
    let Some(horse) = horse() else { return };
    let lattice = &horse.bodies[0].crack;
    let (low, high) = lattice
        .nodes
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), node| (low.min(node.z), high.max(node.z)));
    let legs = lower_legs(lattice, low + LOWER_LEGS * (high - low));
    let count = legs.iter().max().unwrap() + 1;
    let (point, inward) = struck::surface_point(horse, CROUP);
    let energy = struck::energy(horse, &struck::at(point, inward));
    let joined = |lift| {
        (0..12)
            .filter(|&seed| joining_cells(&struck::diagram(horse, lift, &energy.shares, 10, seed), &legs) > 0)
            .count()
    };
    let (interior, euclidean) = (joined(LiftKind::Interior), joined(LiftKind::Euclidean));
    println!("{count} lower legs and tail; seeds of 12 that join two: interior {interior}, euclidean {euclidean}");
    assert!(count >= 4);
    assert_eq!(interior, 0);
    assert!(euclidean > 0, "the test would not notice");
}

/// Volumes, mean energy densities and centres of the cells of one diagram.
struct Cells {
    volumes: Vec<f64>,
    densities: Vec<f64>,
    centres: Vec<Point3<f64>>,
}

fn cells(prepared: &Prepared, diagram: &Diagram, shares: &[f64]) -> Cells {
    let body = &prepared.bodies[0];
    let count = diagram.cell_energy.len();
    let (mut volumes, mut energies, mut firsts) = (vec![0.0; count], vec![0.0; count], vec![Vector3::zeros(); count]);
    for (node, &label) in diagram.labels.iter().enumerate() {
        volumes[label as usize] += body.volumes[node];
        energies[label as usize] += shares[node];
        firsts[label as usize] += body.crack.nodes[node].coords * body.volumes[node];
    }
    Cells {
        densities: energies.iter().zip(&volumes).map(|(energy, volume)| energy / volume).collect(),
        centres: firsts.iter().zip(&volumes).map(|(first, volume)| Point3::from(first / *volume)).collect(),
        volumes,
    }
}

/// Rank correlation of volume with density, and the median volume near the contact over the median far from it.
fn follows(prepared: &Prepared, at: [f64; 3], uniform: bool) -> (f64, f64, Cells) {
    let (point, inward) = struck::surface_point(prepared, at);
    let energy = struck::energy(prepared, &struck::at(point, inward));
    let volumes = &prepared.bodies[0].volumes;
    let total: f64 = volumes.iter().sum();
    let even: Vec<f64> = volumes.iter().map(|volume| volume / total).collect();
    let driving = if uniform { &even } else { &energy.shares };
    let diagram = struck::diagram(prepared, LiftKind::Interior, driving, 40, 3);
    let cells = cells(prepared, &diagram, &energy.shares);
    let contact = prepared.frame.to_local(&point);
    let radius = energy.radius_m / prepared.frame.diagonal_m;
    let near = |centre: &Point3<f64>| (centre - contact).norm() <= 2.0 * radius;
    let side = |wanted: bool| -> Vec<f64> {
        let chosen = cells.centres.iter().zip(&cells.volumes).filter(|(centre, _)| near(centre) == wanted);
        chosen.map(|(_, volume)| *volume).collect()
    };
    let ratio = median(&side(true)) / median(&side(false));
    (rank_correlation(&cells.volumes, &cells.densities), ratio, cells)
}

#[test]
fn fragments_follow_the_deformation() {
    let Some(horse) = horse() else { return };
    let mut patterns = Vec::new();
    for (name, at) in [("head", HEAD), ("croup", CROUP)] {
        let (correlation, ratio, cells) = follows(horse, at, false);
        println!("{name}: rank correlation {correlation:.3}, near/far median volume {ratio:.4}");
        assert!(correlation <= -0.5);
        assert!(ratio <= 1.0 / 3.0);
        patterns.push(cells);
        let (correlation, ratio, _) = follows(horse, at, true);
        println!("{name}, uniform density: rank correlation {correlation:.3}, near/far {ratio:.4}");
        assert!(correlation > -0.5 || !(ratio <= 1.0 / 3.0), "the test would pass without any physics");
    }
    let smallest = |cells: &Cells| {
        let least = (0..cells.volumes.len()).min_by(|&a, &b| cells.volumes[a].total_cmp(&cells.volumes[b])).unwrap();
        cells.centres[least]
    };
    let apart = (smallest(&patterns[0]) - smallest(&patterns[1])).norm();
    println!("the smallest fragments of the two patterns are {apart:.3} diagonals apart");
    assert!(apart > 0.3);
}

#[test]
fn weaker_materials_break_into_more_pieces() {
    let Some(horse) = horse() else { return };
    let (point, inward) = struck::surface_point(horse, HEAD);
    let threshold = struck::outcome(horse, &struck::at(point, inward)).unwrap();
    let strike = struck::at(point, inward * (10.0 * threshold.impulse_factor));
    let own = struck::outcome(horse, &strike).unwrap();
    let weaker = struck::outcome(
        horse,
        &shatter_fracture::pipeline::Strike { gamma_j_m2: Some(horse.gamma_j_m2 / 4.0), ..strike.clone() },
    )
    .unwrap();
    println!("E_1/γ {:.1}: n = {}; γ/4: n = {}", own.e1_over_gamma, own.fracture_degree, weaker.fracture_degree);
    assert!(weaker.fracture_degree > own.fracture_degree);
}

#[test]
fn the_optimised_degree_never_falls_with_gamma() {
    let Some(horse) = horse() else { return };
    let (point, inward) = struck::surface_point(horse, HEAD);
    let just = struck::outcome(horse, &struck::at(point, inward)).unwrap().impulse_factor;
    let mut last = 0;
    for times in [0.5, 0.99, 1.01, 2.0, 3.0, 5.0, 8.0] {
        let mut strike = struck::at(point, inward * (just * times));
        strike.degree = DegreeRequest::Optimised;
        let outcome = struck::outcome(horse, &strike).unwrap();
        println!("{times} × threshold: E_1/γ = {:.3}, n = {}", outcome.e1_over_gamma, outcome.fracture_degree);
        assert_eq!(outcome.fracture_degree == 1, times < 1.0);
        assert_eq!(outcome.degree_source == DegreeSource::Threshold, times < 1.0);
        assert!(outcome.fracture_degree >= last);
        last = outcome.fracture_degree;
    }
}
