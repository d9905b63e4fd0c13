//! Groups of nodes reduce work. They change no label of given sites, and little of the final sites.

use super::*;
use crate::tessellation::Topology;

/// Generic case of 12,000 nodes, with groups of them.
fn grouped(m: usize) -> (Case, Clusters) {
    let lattice = block([16, 14, 12], 0.06);
    let topology = Topology::new(&lattice);
    let energy = |node: &Point3<f64>| 1.0 / ((node - Point3::new(0.3, 0.21, 0.14)).norm_squared() + 0.01);
    (Case::new(&lattice, wavy(&lattice, m), energy), Clusters::new(topology.nodes, |node| topology.neighbors(node)))
}

#[test]
fn groups_change_no_label_of_given_sites() {
    for (m, sites) in [(3, 7), (8, 60), (19, 50), (19, 300)] {
        let (mut case, clusters) = grouped(m);
        let start = case.diagram(DiagramOptions { tolerance: 0.1, ..DiagramOptions::new(sites, 3) });
        let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
        let plain = assign(&field, &start.sites, &mut DiagramWorkspace::default());
        let spared = assign(&field.grouped(&clusters), &start.sites, &mut DiagramWorkspace::default());
        assert!(plain.labels == spared.labels, "m = {m}, {sites} sites");
        assert!((plain.energy - spared.energy).abs() <= 1e-13 * plain.energy);
        check(&field, &DiagramOptions::new(sites, 3), &spared);
    }
}

#[test]
fn coarse_levels_end_as_low_as_the_nodes_alone() {
    let mut ratios = Vec::new();
    for (seed, sites) in [(1, 10), (2, 10), (3, 25), (4, 50), (5, 50), (6, 100)] {
        let (mut case, clusters) = grouped(19);
        let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
        let options = DiagramOptions::new(sites, seed);
        let run = |field: &EnergyField| {
            diagram(field, &options, &mut DiagramWorkspace::default(), &CancelToken::default()).unwrap()
        };
        let (plain, coarse) = (run(&field), run(&field.grouped(&clusters)));
        check(&field, &options, &coarse);
        println!(
            "{sites} sites: {} iterations alone, {} after {} coarse ones, energy {:.4}",
            plain.iterations(),
            coarse.iterations(),
            coarse.coarse_iterations,
            coarse.energy / plain.energy
        );
        assert!(coarse.coarse_iterations > 0 && coarse.iterations() < plain.iterations());
        ratios.push(coarse.energy / plain.energy);
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((mean - 1.0).abs() < 0.02, "{ratios:?}");
}

#[test]
fn groups_of_another_lattice_are_not_taken() {
    let (mut case, _) = grouped(3);
    let (clusters, wanted) = (Clusters::new(500, |_| &[]), DiagramOptions::new(9, 2));
    let plain = case.diagram(wanted);
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap().grouped(&clusters);
    assert!(plain == diagram(&field, &wanted, &mut DiagramWorkspace::default(), &CancelToken::default()).unwrap());
}

#[test]
fn threads_and_instructions_do_not_change_a_bit_of_grouped_diagrams() {
    let (mut case, clusters) = grouped(19);
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap().grouped(&clusters);
    let run = |threads, path| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut workspace = DiagramWorkspace { scratch: AssignScratch::with_path(path), ..DiagramWorkspace::default() };
        pool.install(|| diagram(&field, &DiagramOptions::new(60, 11), &mut workspace, &CancelToken::default()).unwrap())
    };
    let one = run(1, KernelPath::detect());
    assert!(one == run(2, KernelPath::detect()) && one == run(4, KernelPath::baseline()));
}
