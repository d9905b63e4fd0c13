//! Steps of a bake, and estimates of its remaining cost once the lattices are known.

use super::BakeRequest;
use crate::conforming::boundary_count;
use crate::elasticity::ElementOrder;
use crate::pipeline::{BASIS_BYTES_MAX_QUADRATIC, DisplacementMethod, PreparedObject, REFINED_NODES_MAX, SurfaceKind};
use crate::surface::Surface;

/// Steps of a bake in order, for display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeStep {
    /// Welds and orients the surface and reports its defects.
    Surface,
    /// Computes winding numbers and the enclosed volume.
    Volume,
    /// Computes both lattices and the transfer between them.
    Lattices,
    /// Reports the size of the finished lattices, and again if bodies get quadratic elements later. No work begins with it.
    Sized(BakeSize),
    /// Factors the stiffness of body `0`.
    Elasticity(usize),
    /// Computes the eigenpairs of body `0`.
    Lift(usize),
    /// Fills the input surface with tetrahedra.
    ExactSurface {
        /// Repair round, from 0.
        round: u32,
    },
    /// Computes reduced elastic bases from the examples' impacts.
    Reduction,
    /// Fits κ on sampled impacts.
    Calibration,
    /// Computes examples and trains on them.
    Examples {
        /// Number of completed impacts.
        done: u64,
        /// Number of all impacts.
        of: u64,
    },
}

/// Size of a bake, which determines its approximate cost.
///
/// Calibrated on generated shapes in `draft` and `game` (dumbbell, arch, horseshoe, mug, statue, vase: 1 500 to 58 900
/// elastic and 3 000 to 58 900 crack nodes) and on the mug with 24 and 100 examples. Processor times are for one core
/// of an AMD EPYC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeSize {
    /// Total number of nodes of the elastic lattices; 0 without elasticity.
    pub elastic_nodes: usize,
    /// Total number of nodes of the crack lattices.
    pub crack_nodes: usize,
    /// Number of impacts for training.
    pub examples: u64,
    /// Size of the factors in the requested precision, bytes. At equal numbers of nodes, balls need three times as much
    /// as rods.
    pub factor_bytes: u64,
    /// Additional size of the factors if single precision was requested and is too inaccurate, bytes.
    pub double_precision_bytes: u64,
    /// Operations to compute the factors. At equal numbers of nodes, balls need ten times as many as rods.
    pub factor_operations: u64,
    /// Memory of the edge functions of quadratic elements, bytes.
    pub edge_bytes: u64,
    /// Elastic nodes of bodies with quadratic elements.
    pub quadratic_nodes: usize,
    /// Length of the cells of a sheet over their thickness; 1: they are regular.
    pub stretch: u32,
    /// True if a basis of displacements is made.
    pub is_reduced: bool,
    /// Number of triangles of the skin; 0 without a skin.
    pub skin_triangles: usize,
    /// Number of triangles of the exact surface that is filled with tetrahedra; 0 for the lattice's surface.
    pub exact_triangles: usize,
}

/// Reference number of crack nodes for the times below.
const CRACK_NODES: f64 = 9_576.0;

/// Time of one core for lifts and calibration at that number of nodes, and for one example, s.
const CRACK_S: [f64; 2] = [1.7, 0.33];

/// Shortest and longest time of one core per operation of the factorization, which is not parallel, s. A vase of 58,868 nodes took 6.7e-11,
/// a shell of 95,290 nodes 6.5e-11.
const FACTOR_S: [f64; 2] = [5e-11, 1.5e-10];

/// Time of one core per elastic node of a solve with quadratic elements, and of a snapshot of a basis, s. A solve of the
/// mug took 0.09 s, of a strip of 13,170 nodes 0.25 s; a snapshot of the mug took 0.04 s.
const QUADRATIC_S: [f64; 2] = [2e-5, 1e-5];

/// Shortest and longest time of a solve on cells twice as long as thick or more, over that on regular cells, per length. Bakes of
/// panes with 20,000 to 50,000 nodes took 0.9 to 1.3.
const STRETCHED: [f64; 2] = [0.8, 1.4];

/// Solves with quadratic elements for the test of the basis, to fit κ, and to estimate the error of the lattice.
const SOLVES: f64 = 42.0 + 6.0 + 8.0;

/// As [`SOLVES`], for a sheet on long cells.
const SOLVES_SHEET: f64 = 24.0 + 6.0 + 8.0;

/// Snapshots of the basis of quadratic elements per example, and the smallest and largest number of its displacements.
const SNAPSHOTS: [f64; 3] = [3.0, 90.0, 256.0];

/// Snapshots of the basis of a sheet on long cells.
const SNAPSHOTS_SHEET: f64 = 48.0;

/// Shortest and longest time to fill an exact surface, per triangle, s. On an Intel Xeon: arch 1.3e-5, statue 1.6e-5, horse
/// 2.3e-5, mug 2.6e-5 (thin walls of small triangles need many repair rounds). On the EPYC: statue 2.6e-5.
const EXACT_S: [f64; 2] = [1.3e-5, 8e-5];

/// Memory of an object per crack node, per elastic node without the factor, and per triangle of its skin, bytes.
const HELD: [f64; 3] = [1_530.0, 1_490.0, 60.0];

/// Memory of the mesh of an exact surface per crack node and per triangle, bytes.
const HELD_EXACT: [f64; 2] = [800.0, 412.0];

/// Share of the usual memory that an object with an exact surface takes at least: 0.985 for the vase, 0.946 for a plate of 1:83.
const HELD_LEAST: f64 = 0.93;

/// Memory per triangle beyond that where the surface is round and finely divided, bytes: the mesh has 3.4 tetrahedra per triangle of a
/// capsule, and 1.4 of a cylinder.
const EXACT_ROUND: f64 = 340.0;

/// Peak memory of a bake: a constant, bytes, and a multiple of the object's memory. A teapot took 656 MB, of which these are 1.99.
const PEAK: [f64; 2] = [70e6, 2.1];

/// Memory per snapshot and elastic node, bytes: forces, displacement and residual of a node and about seven edges, the last
/// two in single precision, and what is kept of them.
const QUADRATIC_SNAPSHOT: f64 = 3.0 * (8.0 * 16.0 + 32.0);

/// Largest memory of all snapshots, without their forces, bytes.
const QUADRATIC_SNAPSHOTS_MAX: f64 = 1_550e6;

/// Memory of the refined lattice on which the error of the elastic lattice is estimated, per elastic node, bytes.
const REFINED: f64 = 15e3;

/// Memory per displacement of a basis of quadratic elements and elastic node, bytes: three tables of three components in single
/// precision, and the strains.
const QUADRATIC_BASIS: f64 = 3.0 * 3.0 * 4.0 + 6.0 * 2.0;

impl BakeSize {
    /// The size of an object whose surface is `surface`.
    pub(super) fn of(prepared: &PreparedObject, surface: &Surface, request: &BakeRequest) -> Self {
        let solids = || prepared.bodies.iter().filter_map(|body| body.solid.as_ref());
        // The skin and the exact surface have edges of at most the same length: their numbers differ by a tenth at most.
        let triangles = boundary_count(&surface.positions, &surface.triangles, prepared.parameters.crack_spacing);
        Self {
            elastic_nodes: solids().map(|solid| solid.lattice.nodes.len()).sum(),
            crack_nodes: prepared.crack_nodes(),
            examples: request.examples,
            factor_bytes: solids().map(|solid| solid.elasticity.factor_bytes() as u64).sum(),
            double_precision_bytes: solids().map(|solid| solid.elasticity.double_precision_bytes() as u64).sum(),
            factor_operations: solids().map(|solid| solid.elasticity.factor_operations()).sum(),
            edge_bytes: solids().map(|solid| solid.elasticity.edge_bytes() as u64).sum(),
            quadratic_nodes: solids()
                .filter(|solid| solid.elasticity.order() == ElementOrder::Quadratic)
                .map(|solid| solid.lattice.nodes.len())
                .sum(),
            stretch: prepared.report.stretch.map_or(1, |own| own.factor as u32),
            is_reduced: request.elastic == DisplacementMethod::Reduced,
            skin_triangles: if request.tables().skin { triangles } else { 0 },
            exact_triangles: match request.surface {
                SurfaceKind::Exact => triangles,
                SurfaceKind::Lattice => 0,
            },
        }
    }

    /// Approximate time of the rest of the bake on that many threads, s: the shortest and the longest. Most of it runs on all
    /// threads; the exact surface is filled by one.
    pub fn seconds(&self, threads: usize) -> [f64; 2] {
        let crack = self.crack_nodes as f64 / CRACK_NODES;
        let [solve, snapshot] = QUADRATIC_S;
        let solves = if self.stretch > 1 { SOLVES_SHEET } else { SOLVES };
        let solves = solves + self.examples as f64;
        let quadratic = (solve * solves + snapshot * self.snapshots()) * self.quadratic_nodes as f64;
        let longer = STRETCHED.map(|share| if self.stretch > 1 { share * f64::from(self.stretch) } else { 1.0 });
        let shared = longer.map(|longer| longer * quadratic + crack * (CRACK_S[0] + CRACK_S[1] * self.examples as f64));
        let [least, most] = EXACT_S.map(|triangle| triangle * self.exact_triangles as f64);
        let [fast, slow] = FACTOR_S.map(|operation| operation * self.factor_operations as f64);
        [least + fast + shared[0] / threads as f64, most + slow + shared[1]]
    }

    /// Number of snapshots for the basis of quadratic elements.
    fn snapshots(&self) -> f64 {
        if !self.is_reduced {
            return 0.0;
        }
        let least = if self.stretch > 1 { SNAPSHOTS_SHEET } else { SNAPSHOTS[1] };
        (SNAPSHOTS[0] * self.examples as f64).max(least)
    }

    /// Largest number of displacements of the basis of quadratic elements.
    fn rank(&self) -> f64 {
        let most = BASIS_BYTES_MAX_QUADRATIC / (3 * size_of::<f32>() * self.quadratic_nodes.max(1));
        self.snapshots().min(SNAPSHOTS[2]).min(most as f64)
    }

    /// Approximate memory of the object in a daemon, bytes: the least and the most. They differ with an exact surface, which takes more
    /// tetrahedra per triangle where it is round and finely divided.
    pub fn held_bytes(&self) -> [u64; 2] {
        let [crack, elastic, triangle] = HELD;
        let nodes = crack * self.crack_nodes as f64 + elastic * self.elastic_nodes as f64;
        let lattices = nodes + triangle * self.skin_triangles as f64;
        let exact = match self.exact_triangles {
            0 => 0.0,
            triangles => HELD_EXACT[0] * self.crack_nodes as f64 + HELD_EXACT[1] * triangles as f64,
        };
        let basis = QUADRATIC_BASIS * self.rank() * self.quadratic_nodes as f64;
        let round = EXACT_ROUND * self.exact_triangles as f64;
        let usual = self.factor_bytes + self.edge_bytes + (lattices + exact + basis) as u64;
        let [least, most] = match self.exact_triangles {
            0 => [usual; 2],
            _ => [(HELD_LEAST * usual as f64) as u64, usual + round as u64],
        };
        [least, most + self.double_precision_bytes]
    }

    /// Approximate peak memory of the bake, bytes.
    pub fn peak_bytes(&self) -> u64 {
        let snapshots = QUADRATIC_SNAPSHOT * self.snapshots() * self.quadratic_nodes as f64;
        let snapshots = snapshots.min(QUADRATIC_SNAPSHOTS_MAX);
        let linear = self.elastic_nodes - self.quadratic_nodes;
        let refined = if linear > REFINED_NODES_MAX { 0.0 } else { REFINED * linear as f64 };
        let [_, held] = self.held_bytes();
        (PEAK[0] + PEAK[1] * held as f64 + snapshots.max(refined)) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::database::bake;
    use crate::pipeline::Preset;
    use crate::scene::Materials;
    use crate::surface::shapes;

    const MUG: BakeSize = BakeSize {
        elastic_nodes: 4_645,
        crack_nodes: 9_576,
        examples: 0,
        factor_bytes: 27_200_000,
        double_precision_bytes: 0,
        factor_operations: 3_000_000_000,
        edge_bytes: 0,
        quadratic_nodes: 0,
        stretch: 1,
        is_reduced: true,
        skin_triangles: 130_196,
        exact_triangles: 0,
    };

    #[test]
    fn the_peak_is_near_what_was_measured() {
        let peak = MUG.peak_bytes() as f64 / 228.6e6;
        assert!((1.0..1.2).contains(&peak), "{peak}");
        // With quadratic elements 394 MB were measured, and 84 MB in a daemon.
        let quadratic = BakeSize { elastic_nodes: 4_596, quadratic_nodes: 4_596, edge_bytes: 4_708_208, ..MUG };
        let [peak, held] = [quadratic.peak_bytes() as f64 / 394e6, quadratic.held_bytes()[0] as f64 / 83.8e6];
        assert!((1.0..1.2).contains(&peak) && (0.95..1.1).contains(&held), "{peak} and {held}");
    }

    #[test]
    fn no_basis_takes_less_time_and_memory() {
        let quadratic = BakeSize { elastic_nodes: 4_596, quadratic_nodes: 4_596, edge_bytes: 4_708_208, ..MUG };
        let solved = BakeSize { is_reduced: false, ..quadratic };
        assert!(solved.seconds(2)[1] < 0.7 * quadratic.seconds(2)[1]);
        assert!(solved.held_bytes()[0] < quadratic.held_bytes()[0] - 15_000_000);
        assert!(solved.peak_bytes() < quadratic.peak_bytes());
    }

    #[test]
    fn requested_tables_increase_the_cost() {
        let learning = BakeSize { examples: 100, ..MUG };
        let [least, most] = MUG.seconds(2);
        assert!(2.0 * least < most && learning.seconds(1)[1] > 10.0 * most);
        let narrow = BakeSize { factor_bytes: 13_600_000, double_precision_bytes: 13_600_000, ..MUG };
        assert_eq!(narrow.held_bytes(), [MUG.held_bytes()[0] - 13_600_000, MUG.held_bytes()[1]]);
        let hollow = BakeSize { elastic_nodes: 0, factor_bytes: 0, factor_operations: 0, ..MUG };
        assert!(hollow.held_bytes()[1] < hollow.peak_bytes() && hollow.seconds(1)[1] < most);
        let exact = BakeSize { exact_triangles: 130_196, ..MUG };
        let serial = [exact.seconds(1)[0] - MUG.seconds(1)[0], exact.seconds(2)[0] - least];
        assert!(serial[0] > 1.0 && (serial[0] - serial[1]).abs() < 1e-9, "one thread fills the surface: {serial:?}");
        let taken = [exact.seconds(2)[0] - least, exact.seconds(2)[1] - most];
        assert!(taken[0] < 3.4 && 3.4 < taken[1] && taken[1] < 7.0 * taken[0], "3.4 s were measured: {taken:?}");
        let [least, most] = exact.held_bytes().map(|bytes| bytes as f64 / 118.9e6);
        assert!(least < 1.0 && 1.0 < most && most < 1.5 * least, "{least} to {most}");
    }

    /// Of two bodies with as many nodes, the factor of a pane beside a ball takes 25 times as long as that of a shell.
    #[test]
    fn the_time_follows_the_operations_of_the_factor() {
        let sized = |nodes, factor_operations| {
            BakeSize { elastic_nodes: nodes, crack_nodes: nodes, factor_operations, skin_triangles: 0, ..MUG }
                .seconds(2)
        };
        let [shell, pane] = [sized(95_290, 205_000_000_000), sized(67_806, 4_990_000_000_000)];
        assert!(shell[0] < 25.7 && 25.7 < shell[1], "25.7 s of one core were measured: {shell:?}");
        assert!(pane[0] > 200.0 && pane[1] < 4.0 * pane[0], "{pane:?}");
    }

    /// A turned pane of 1 m × 1 m × 4 mm took 142 s on two cores after it was sized.
    #[test]
    fn the_time_of_a_sheet_follows_the_length_of_its_cells() {
        let sized = |stretch| {
            let (elastic_nodes, crack_nodes, quadratic_nodes) = (23_688, 23_800, 23_688);
            BakeSize { elastic_nodes, crack_nodes, quadratic_nodes, stretch, skin_triangles: 0, ..MUG }.seconds(2)
        };
        let (regular, [least, most]) = (sized(1), sized(6));
        assert!(least < 142.0 && 142.0 < most && most < 4.0 * least, "{least} to {most}");
        assert!(regular[1] < least, "{regular:?}");
    }

    #[test]
    fn stiffness_is_factored_before_the_lifts_because_it_may_be_refused() {
        let request = BakeRequest {
            elastic_spacing: Some(0.2),
            crack_spacing: Some(0.2),
            surface: SurfaceKind::Lattice,
            kappa: Some(2.0),
            ..BakeRequest::new("block", "glass", crate::scene::Material::named("glass").unwrap())
        };
        let mut steps = Vec::new();
        bake(shapes::cuboid([0.3; 3]), &request, &CancelToken::default(), &mut |step| steps.push(step)).unwrap();
        let place = |wanted: BakeStep| steps.iter().position(|step| *step == wanted).unwrap();
        assert!(place(BakeStep::Elasticity(0)) < place(BakeStep::Lift(0)), "{steps:?}");
    }

    #[test]
    fn the_memory_estimate_is_near_the_measured_memory() {
        let materials = Materials::parse(crate::scene::MATERIALS).unwrap();
        let lattice = [("arch", Preset::Draft), ("dumbbell", Preset::Draft), ("mug", Preset::Draft)]
            .map(|(shape, quality)| (shape, quality, SurfaceKind::Lattice));
        let exact = ("dumbbell", Preset::Game, SurfaceKind::Exact);
        for (shape, quality, surface) in lattice.into_iter().chain([exact]) {
            let glass = materials.get("glass").unwrap().clone();
            let request = BakeRequest { quality, surface, kappa: Some(2.0), ..BakeRequest::new(shape, "glass", glass) };
            let mut estimated_bytes = [0; 2];
            let mut on_step = |step| {
                if let BakeStep::Sized(size) = step {
                    estimated_bytes = size.held_bytes();
                }
            };
            let prepared =
                bake(shapes::by_name(shape).unwrap(), &request, &CancelToken::default(), &mut on_step).unwrap();
            let [least, most] = estimated_bytes.map(|bytes| bytes as f64 / prepared.bytes() as f64);
            println!("{shape} {} {surface:?}: {least:.3} to {most:.3} of the bytes held", quality.name());
            assert!(least < 1.05 && most > 0.95 && most < 1.5 * least, "{shape} {}: {least} to {most}", quality.name());
        }
    }
}
