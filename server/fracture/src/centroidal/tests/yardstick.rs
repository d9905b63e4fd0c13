//! Diagrams against known numbers.

use super::*;

/// Normalized second moment of the body-centered cubic lattice, the best known in R³.
const BCC: f64 = 0.0785433;

/// The moments exceed that of the lattice for three reasons: flat outer faces, an iteration that stops at a local
/// minimum, and cells that consist of whole nodes.
#[test]
fn uniform_cells_come_close_to_the_best_known_quantiser() {
    for (sites, cells) in [(30, 12), (60, 12), (60, 18)] {
        let mut case = Case::cube(cells);
        let result = case.diagram(DiagramOptions { tolerance: 1e-4, ..DiagramOptions::new(sites, 1) });
        let mean = result.cell_energy.iter().sum::<f64>() / sites as f64;
        let moment = mean / 3.0 / (1.0 / sites as f64).powf(5.0 / 3.0);
        println!("{sites} sites: normalized second moment {moment:.5}, {:.3} of BCC", moment / BCC);
        assert!(moment > BCC && moment < 1.12 * BCC, "{sites} sites: {moment}");
    }
}

#[test]
fn cell_energies_do_not_depend_on_the_spacing() {
    let coarse = Case::cube(8).diagram(DiagramOptions::new(12, 6));
    let energies = |cells: usize| {
        let mut case = Case::cube(cells);
        let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
        let result = assign(&field, &coarse.sites, &mut DiagramWorkspace::default());
        (result.energy, result.cell_energy)
    };
    let (coarse_plain, coarse_full) = energies(8);
    let (fine_plain, fine_full) = energies(16);
    let worst = coarse_full.iter().zip(&fine_full).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let (full, plain) = (coarse_full.iter().sum::<f64>() / fine_full.iter().sum::<f64>(), coarse_plain / fine_plain);
    println!("worst cell {worst:.4}, sum {full:.4}, without the nodes' own cells {plain:.4}");
    assert!(worst < 0.06, "{worst}");
    assert!((full - 1.0).abs() < 0.02 && (full - 1.0).abs() < (plain - 1.0).abs(), "{full} {plain}");
}
