//! Invariants of every diagram, and the fields on which they are tested.

mod grouped;
mod hard;
mod invariance;
mod yardstick;

use super::assign::AssignScratch;
use super::kernel::KernelPath;
use super::vector::square_distance;
use super::*;
use crate::lattice::{Lattice, block};
use crate::lift::{LiftKind, LiftedLattice};
use nalgebra::Point3;

/// Lattice data, its lift and an energy density, owned, so that fields can borrow from it.
pub(super) struct Case {
    pub lift: LiftedLattice,
    pub volumes: Vec<f64>,
    pub mass: Vec<f64>,
}

impl Case {
    /// Density `energy` on `lattice`, lifted by `lift`.
    pub fn new(lattice: &Lattice, lift: LiftedLattice, energy: impl Fn(&Point3<f64>) -> f64) -> Self {
        let volumes = lattice.node_volumes();
        let mass = lattice.nodes.iter().zip(&volumes).map(|(node, volume)| volume * energy(node)).collect();
        Self { lift, volumes, mass }
    }

    /// Case without symmetry, with `m` ≥ 3 coordinates and energy concentrated in a corner; 2969 nodes, three chunks.
    pub fn generic(m: usize) -> Self {
        let lattice = block([8, 8, 8], 0.09);
        Self::new(&lattice, wavy(&lattice, m), |node| {
            1.0 / ((node - Point3::new(0.3, 0.21, 0.14)).norm_squared() + 0.01)
        })
    }

    /// Case W = 1 on a cube of `cells`³ cells and side 1, not lifted.
    pub fn cube(cells: usize) -> Self {
        let lattice = block([cells; 3], 1.0 / cells as f64);
        Self::new(&lattice, LiftedLattice::euclidean(&lattice), |_| 1.0)
    }

    /// Diagram on a fresh workspace, after all checks of [`check`].
    pub fn diagram(&mut self, options: DiagramOptions) -> Diagram {
        let field = EnergyField::new(&self.lift, &self.volumes, &mut self.mass).unwrap();
        let diagram = diagram(&field, &options, &mut DiagramWorkspace::default(), &CancelToken::default()).unwrap();
        check(&field, &options, &diagram);
        diagram
    }
}

/// Lift of x and m − 3 waves of x, scaled.
fn wavy(lattice: &Lattice, m: usize) -> LiftedLattice {
    let wave = |node: &Point3<f64>, k: usize| {
        let k = k as f64;
        0.3 / (1.0 + k) * ((3.0 + 0.7 * k) * node.x - (2.0 + 1.3 * k) * node.y + (1.0 + k * 0.4) * node.z + k).sin()
    };
    let row = |node: &Point3<f64>| {
        let waves: Vec<f64> = (0..m - 3).map(|k| wave(node, k)).collect();
        [node.x, node.y, node.z].into_iter().chain(waves)
    };
    LiftedLattice::scaled(LiftKind::Interior, lattice, m, lattice.nodes.iter().flat_map(row).collect())
}

/// Checks the invariants of every diagram.
pub(super) fn check(field: &EnergyField, options: &DiagramOptions, diagram: &Diagram) {
    assert_eq!(diagram.count(), options.sites.clamp(1, field.nodes()));
    assert_eq!(diagram.labels.len(), field.nodes());
    assert_eq!(diagram.sites.len(), diagram.count() * field.dimension());
    assert!(diagram.history.windows(2).all(|pair| pair[1] <= pair[0]), "the energy rose: {:?}", diagram.history);
    assert_eq!(diagram.history.last(), Some(&diagram.energy));
    let mut energies = vec![0.0; diagram.count()];
    let (mut plain, mut own) = (0.0, 0.0);
    for (node, &label) in diagram.labels.iter().enumerate() {
        let place = field.lift().at(node);
        let distances = (0..diagram.count()).map(|site| square_distance(place, diagram.site(site)));
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        assert_eq!(label as usize, nearest.0, "node {node} is not in the cell of its nearest site");
        let (mass, moment) = (field.mass()[node], field.cell_moment(node, diagram.site(nearest.0)));
        energies[label as usize] += mass * (nearest.1 + moment);
        plain += mass * nearest.1;
        own += mass * moment;
    }
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (plain + own);
    assert!(diagram.cell_energy.iter().all(|energy| *energy >= 0.0));
    assert!(close(plain, diagram.energy));
    assert!(energies.iter().zip(&diagram.cell_energy).all(|(a, b)| close(*a, *b)));
    assert!(close(diagram.cell_energy.iter().sum(), plain + own));
}

#[test]
fn a_generic_field_is_divided_and_no_cell_is_empty() {
    for (m, sites) in [(3, 40), (4, 7), (16, 40), (19, 100)] {
        let diagram = Case::generic(m).diagram(DiagramOptions::new(sites, 7));
        assert!(diagram.converged && diagram.iterations() >= 3);
        let filled = (0..sites as u32).all(|site| diagram.labels.contains(&site));
        assert!(filled);
        assert!(diagram.energy < 0.8 * diagram.history[0], "{:?}", diagram.history);
    }
}

#[test]
fn sites_end_near_their_centroids_and_nearer_with_a_smaller_tolerance() {
    let drift = |tolerance: f64| {
        let mut case = Case::generic(5);
        let diagram = case.diagram(DiagramOptions { tolerance, ..DiagramOptions::new(30, 3) });
        let mut sums = vec![[0.0; 6]; 30];
        for (node, &label) in diagram.labels.iter().enumerate() {
            let sum = &mut sums[label as usize];
            sum[5] += case.mass[node];
            (0..5).for_each(|axis| sum[axis] += case.mass[node] * case.lift.at(node)[axis]);
        }
        let offset = |site: usize| {
            let centroid: Vec<f64> = (0..5).map(|axis| sums[site][axis] / sums[site][5]).collect();
            square_distance(&centroid, diagram.site(site)) * sums[site][5]
        };
        (0..30).map(offset).sum::<f64>() / diagram.energy
    };
    let (coarse, fine) = (drift(1e-2), drift(1e-5));
    assert!(coarse < 0.02 && fine < 1e-4 && fine < coarse, "{coarse} {fine}");
}

#[test]
fn memory_is_reused_from_diagram_to_diagram() {
    let mut case = Case::generic(6);
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
    let (mut workspace, mut result) = (DiagramWorkspace::default(), Diagram::default());
    let mut run = |sites| {
        diagram_into(&field, &DiagramOptions::new(sites, 5), &mut workspace, &CancelToken::default(), &mut result)
            .unwrap();
        let states = [workspace.current.labels.as_ptr(), workspace.trial.labels.as_ptr()];
        (states.iter().min().copied(), states.iter().max().copied(), result.labels.as_ptr(), result.labels.clone())
    };
    let first = run(30);
    run(12);
    assert_eq!(first, run(30), "same memory, same labels");
}

#[test]
fn a_canceled_token_ends_the_descent() {
    let mut case = Case::generic(3);
    let field = EnergyField::new(&case.lift, &case.volumes, &mut case.mass).unwrap();
    let token = CancelToken::default();
    token.cancel();
    assert_eq!(diagram(&field, &DiagramOptions::new(9, 1), &mut DiagramWorkspace::default(), &token), Err(Canceled));
}
