//! Cases: diagrams of fields that are hard to divide.

use super::super::trial::{TrialFault, at, baked, coarse, difference, sites, sound, struck};
use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{Diagram, DiagramOptions, DiagramWorkspace, EnergyField, FieldError, diagram};
use shatter_fracture::lattice::{Lattice, block};
use shatter_fracture::lift::LiftedLattice;
use shatter_fracture::pipeline::FractureRequest;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_fracture::tessellation::{Topology, components};

impl From<FieldError> for TrialFault {
    fn from(error: FieldError) -> Self {
        Self::ours("field", error.to_string())
    }
}

/// Computes a diagram on a lattice; `change` may alter lift and masses.
fn divided(
    lattice: &Lattice,
    options: DiagramOptions,
    change: impl FnOnce(&mut LiftedLattice, &mut Vec<f64>),
) -> Result<Diagram, TrialFault> {
    let (mut lift, volumes) = (LiftedLattice::euclidean(lattice), lattice.node_volumes());
    let mut masses = volumes.clone();
    change(&mut lift, &mut masses);
    let field = EnergyField::new(&lift, &volumes, &mut masses)?;
    diagram(&field, &options, &mut DiagramWorkspace::default(), &CancelToken::default())
        .map_err(|canceled| TrialFault::ours("canceled", canceled.to_string()))
}

/// Largest relative rise of Lloyd's energy from one iteration to the next; infinite if it is not finite.
fn rise(diagram: &Diagram) -> f64 {
    if !diagram.cell_energy.iter().chain(&diagram.sites).all(|number| number.is_finite()) {
        return f64::INFINITY;
    }
    let rises = diagram.history.windows(2).map(|pair| (pair[1] - pair[0]) / pair[0].max(f64::MIN_POSITIVE));
    rises.fold(0.0, f64::max)
}

pub fn coincident_nodes() -> Result<f64, TrialFault> {
    let result = divided(&block([3; 3], 0.1), DiagramOptions::new(6, 1), |lift, _| {
        lift.coordinates.fill(0.25);
        lift.first_moment.fill(0.0);
    })?;
    Ok(rise(&result) + f64::from(u8::from(!result.converged)))
}

pub fn all_energy_at_one_node() -> Result<f64, TrialFault> {
    let result = divided(&block([6; 3], 0.1), DiagramOptions::new(40, 9), |_, masses| {
        masses.fill(0.0);
        masses[77] = 3.0;
    })?;
    let mut used = result.labels.clone();
    used.sort_unstable();
    used.dedup();
    Ok(rise(&result) + (40 - used.len()) as f64)
}

pub fn more_sites_than_nodes() -> Result<f64, TrialFault> {
    let lattice = block([2; 3], 0.1);
    let result = divided(&lattice, DiagramOptions::new(10 * lattice.nodes.len(), 3), |_, _| ())?;
    Ok(rise(&result) + (result.count() as f64 - lattice.nodes.len() as f64).abs())
}

pub fn more_sites_than_nodes_struck() -> Result<f64, TrialFault> {
    let mut request = coarse()?;
    (request.elastic_spacing, request.crack_spacing) = (Some(0.25), Some(0.25));
    let prepared = baked(shapes::cuboid([1.0; 3]), &request)?;
    let result = struck(&prepared, &sites(at(&prepared, [1.0, 0.1, 0.2]), 512))?;
    sound(&prepared, &result)
}

pub fn no_energy() -> Result<f64, TrialFault> {
    Ok(rise(&divided(&block([3; 3], 0.1), DiagramOptions::new(6, 1), |_, masses| masses.fill(0.0))?))
}

pub fn negative_energy() -> Result<f64, TrialFault> {
    Ok(rise(&divided(&block([3; 3], 0.1), DiagramOptions::new(6, 1), |_, masses| masses[5] = -1.0)?))
}

pub fn thirty_decades() -> Result<f64, TrialFault> {
    let result = divided(&block([8; 3], 0.1), DiagramOptions::new(50, 2), |lift, masses| {
        let far = |node: usize| 30.0 * (lift.at(node)[0] + 0.4) / 0.8;
        masses.iter_mut().enumerate().for_each(|(node, mass)| *mass *= 10.0_f64.powf(-far(node)));
    })?;
    Ok(rise(&result))
}

/// Normalized second moment of the cells of a uniform cube, over that of the body-centered cubic lattice.
pub fn yardstick() -> Result<f64, TrialFault> {
    let sites = 60;
    let lattice = block([18; 3], 1.0 / 18.0);
    let result = divided(&lattice, DiagramOptions { tolerance: 1e-4, ..DiagramOptions::new(sites, 1) }, |_, _| ())?;
    let mean = result.cell_energy.iter().sum::<f64>() / sites as f64;
    Ok(mean / 3.0 / (1.0 / sites as f64).powf(5.0 / 3.0) / 0.0785433)
}

/// Largest relative difference between the results of the same symmetric request on one and on four threads.
fn repeated(mesh: RawMesh, point: [f64; 3]) -> Result<f64, TrialFault> {
    let prepared = baked(mesh, &coarse()?)?;
    let strike = sites(FractureRequest::at(Point3::from(point), -Vector3::from(point).normalize()).seeded(1), 16);
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| TrialFault::ours("threads", e.to_string()))
    };
    let one = pool(1)?.install(|| struck(&prepared, &strike))?;
    let four = pool(4)?.install(|| struck(&prepared, &strike))?;
    sound(&prepared, &one)?;
    let same = one.positions == four.positions && one.indices == four.indices;
    Ok(if same { difference(&one, &four, 1.0) } else { f64::INFINITY })
}

pub fn cube_at_a_face_center() -> Result<f64, TrialFault> {
    repeated(shapes::cuboid([1.0; 3]), [0.5, 0.0, 0.0])
}

pub fn sphere_at_a_pole() -> Result<f64, TrialFault> {
    repeated(shapes::sphere(0.5, 4), [0.0, 0.5, 0.0])
}

pub fn torus_on_its_rim() -> Result<f64, TrialFault> {
    repeated(shapes::torus(1.0, 0.35, [64, 32]), [1.35, 0.0, 0.0])
}

/// Number of components beyond the number of sites in a diagram of two clumps of energy, over the number of sites.
pub fn two_clumps() -> Result<f64, TrialFault> {
    let lattice = block([12, 4, 4], 0.1);
    let result = divided(&lattice, DiagramOptions::new(8, 4), |lift, masses| {
        let far = |node: usize| (lift.at(node)[0].abs() - 0.5).abs();
        masses.iter_mut().enumerate().for_each(|(node, mass)| *mass *= (-60.0 * far(node)).exp());
    })?;
    let pieces = components(&Topology::new(&lattice), &result.labels).sites.len();
    Ok(rise(&result) + (pieces as f64 - 8.0) / 8.0)
}
