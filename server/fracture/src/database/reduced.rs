//! Conversion of reduced bases to tensors, and back.

use super::container::{ContainerContents, FLAT, Tensors};
use super::{DatabaseError, stored_values};
use crate::elasticity::{
    CompletionTables, Elasticity, ElementOrder, ErrorEstimate, QuadraticTables, ReducedBasis, ScaledRows,
};
use crate::pipeline::{AnchoredBasis, PreparedBody, PreparedObject, RANK_MAX};
use std::sync::Arc;

/// Metadata key of the errors of all bases; absent without bases.
pub(super) const REDUCTION_KEY: &str = "reduction";

/// Largest number of bases of anchored bodies of one object.
const ANCHORED_MAX: usize = 256;

/// Name of a tensor of body `index`.
fn name(index: usize, part: &str) -> String {
    format!("reduced{index}.{part}")
}

/// Name of a tensor of the basis number `number` of anchored bodies, which is one of body `index`.
fn anchored_name(number: usize, index: usize, part: &str) -> String {
    name(index, &format!("anchored{number}.{part}"))
}

/// Adds the bases of all bodies that have one, free and anchored.
pub(super) fn put(tensors: &mut Tensors, prepared: &PreparedObject) {
    for (index, body) in prepared.bodies.iter().enumerate() {
        if let Some(reduced) = body.reduced() {
            put_basis(tensors, &|part| name(index, part), reduced);
        }
    }
    for (number, AnchoredBasis { body, nodes, basis }) in prepared.anchored_bases.iter().enumerate() {
        let name = |part: &str| anchored_name(number, *body, part);
        tensors.u32(name("nodes"), &[nodes.len()], nodes);
        put_basis(tensors, &name, basis);
    }
}

fn put_basis(tensors: &mut Tensors, name: &dyn Fn(&str) -> String, reduced: &ReducedBasis) {
    let rank = reduced.rank();
    let shape = [reduced.basis().len() / rank, rank];
    tensors.f32(name("basis"), &shape, reduced.basis());
    tensors.f64(name("gram"), &[rank, rank], reduced.gram());
    if let Some(QuadraticTables { strains, weighted, inertial, completion }) = reduced.quadratic() {
        tensors.f32(name("strains"), &[2 * shape[0], rank], &strains.to_rows());
        tensors.f32(name("weighted"), &shape, weighted);
        tensors.f64(name("inertial"), &[QuadraticTables::INERTIAL, rank], inertial);
        if let Some(CompletionTables { forces, estimate }) = completion {
            tensors.f32(name("forces"), &shape, forces);
            put_estimate(tensors, name("completed"), *estimate);
        }
    }
    if let Some(mass) = reduced.mass() {
        tensors.f64(name("mass"), &[rank, rank], mass);
    }
    put_estimate(tensors, name("estimate"), reduced.estimate());
}

/// Adds the two numbers of an error model, and its bound if it has one.
fn put_estimate(tensors: &mut Tensors, name: String, ErrorEstimate { factor, power, error_max }: ErrorEstimate) {
    let values = [factor, power, error_max];
    let count = if error_max.is_finite() { 3 } else { 2 };
    tensors.f64(name, &[count], &values[..count]);
}

/// The basis of the free body `index`; `None` if the file has none.
pub(super) fn reduced(
    contents: &ContainerContents,
    index: usize,
    elasticity: &Elasticity,
) -> Result<Option<ReducedBasis>, DatabaseError> {
    read_basis(contents, &|part| name(index, part), elasticity)
}

/// The bases of anchored `bodies`.
pub(super) fn anchored(
    contents: &ContainerContents,
    bodies: &[PreparedBody],
) -> Result<Vec<AnchoredBasis>, DatabaseError> {
    let mut bases = Vec::new();
    for number in 0..=ANCHORED_MAX {
        let is_own = |index: &usize| contents.holds(&anchored_name(number, *index, "nodes"));
        let Some(body) = (0..bodies.len()).find(is_own) else { return Ok(bases) };
        let name = |part: &str| anchored_name(number, body, part);
        let tensor = name("nodes");
        let Some(solid) = &bodies[body].solid else { return Ok(bases) };
        let count = solid.lattice.nodes.len();
        let nodes = contents.u32(&tensor, None, FLAT, count as u64)?;
        if let Some(index) = nodes.windows(2).position(|pair| pair[1] <= pair[0]) {
            let value = f64::from(nodes[index + 1]);
            return Err(stored_values::implausible(&tensor, index + 1, value, "a node after the one before it"));
        }
        let failed = |source| DatabaseError::Elasticity { body, source };
        let elasticity = solid.elasticity.anchored_unfactored(nodes.clone()).map_err(failed)?;
        let basis = read_basis(contents, &name, &elasticity)?;
        bases.extend(basis.map(|basis| AnchoredBasis { body, nodes, basis: Arc::new(basis) }));
    }
    Err(DatabaseError::TooLarge { what: "bases of anchored bodies", found: ANCHORED_MAX + 1, cap: ANCHORED_MAX })
}

fn read_basis(
    contents: &ContainerContents,
    name: &dyn Fn(&str) -> String,
    elasticity: &Elasticity,
) -> Result<Option<ReducedBasis>, DatabaseError> {
    let basis = name("basis");
    if !contents.holds(&basis) {
        return Ok(None);
    }
    let (rank, entries) = contents.f32(&basis, elasticity.size())?;
    if !(1..=RANK_MAX).contains(&rank) {
        return Err(DatabaseError::TooLarge { what: "columns of a basis", found: rank, cap: RANK_MAX });
    }
    stored_values::basis(&basis, &entries)?;
    let estimate = estimate(contents, name("estimate"))?;
    let gram = contents.f64(&name("gram"), Some(rank), rank)?;
    stored_values::gram(&name("gram"), rank, &gram)?;
    let reduced = match elasticity.order() {
        ElementOrder::Linear => ReducedBasis::stored(elasticity, rank, entries, gram, estimate),
        ElementOrder::Quadratic => {
            let tables = quadratic(contents, name, elasticity.size(), &entries, rank)?;
            ReducedBasis::stored_quadratic(elasticity, entries, gram, tables, estimate)
        }
    };
    with_mass(contents, name("mass"), reduced).map(Some)
}

/// `reduced` with the masses in `tensor`. Files of earlier versions have none.
fn with_mass(
    contents: &ContainerContents,
    tensor: String,
    reduced: ReducedBasis,
) -> Result<ReducedBasis, DatabaseError> {
    let rank = reduced.rank();
    if !contents.holds(&tensor) {
        return Ok(reduced);
    }
    let mass = contents.f64(&tensor, Some(rank), rank)?;
    stored_values::gram(&tensor, rank, &mass)?;
    let (first, reduced) = (mass[0], reduced.with_mass(mass));
    match reduced.modes() {
        Some(_) => Ok(reduced),
        None => Err(stored_values::implausible(&tensor, 0, first, "an entry of a positive definite matrix")),
    }
}

/// The error model in `tensor`.
fn estimate(contents: &ContainerContents, tensor: String) -> Result<ErrorEstimate, DatabaseError> {
    let fitted = contents.f64(&tensor, None, FLAT)?;
    if let Some(index) = fitted.iter().position(|value| *value <= 0.0) {
        return Err(DatabaseError::NotPositive { tensor, index, value: fitted[index] });
    }
    match fitted[..] {
        [factor, power] => Ok(ErrorEstimate { factor, power, ..ErrorEstimate::RAW }),
        [factor, power, error_max] => Ok(ErrorEstimate { factor, power, error_max }),
        _ => {
            let (found, wanted) = (format!("[{}]", fitted.len()), "[2] or [3]".to_owned());
            Err(DatabaseError::Shape { tensor, found, wanted })
        }
    }
}

/// The tables of a basis of quadratic displacements of a body, which has `size` unknowns of nodes, and this `basis`.
fn quadratic(
    contents: &ContainerContents,
    name: &dyn Fn(&str) -> String,
    size: usize,
    basis: &[f32],
    rank: usize,
) -> Result<QuadraticTables, DatabaseError> {
    let rows = |part: &str, rows: usize| {
        let tensor = name(part);
        let (found, entries) = contents.f32(&tensor, rows)?;
        if found != rank {
            let (found, wanted) = (format!("{found} columns"), format!("{rank}, the rank of the basis"));
            return Err(DatabaseError::Shape { tensor, found, wanted });
        }
        stored_values::basis(&tensor, &entries)?;
        Ok(entries)
    };
    let (strains, weighted) = (ScaledRows::new(rank, &rows("strains", 2 * size)?), rows("weighted", size)?);
    let inertial = contents.f64(&name("inertial"), Some(QuadraticTables::INERTIAL), rank)?;
    stored_values::inertial(&name("inertial"), rank, &inertial, [basis, &weighted])?;
    // Files of earlier versions have none.
    let completion = if contents.holds(&name("forces")) {
        Some(CompletionTables { forces: rows("forces", size)?, estimate: estimate(contents, name("completed"))? })
    } else {
        None
    };
    Ok(QuadraticTables { strains, weighted, inertial, completion })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::altered_tests::{Trial, load_altered};
    use crate::database::{BakeRequest, Tables, load, save};
    use crate::elasticity::{ContactLoad, ElasticWorkspace, NodalLoad};
    use crate::lift::LiftKind;
    use crate::pipeline::{ElementChoice, ReductionErrors};
    use crate::scene::Material;
    use crate::surface::shapes;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn a_basis_of_quadratic_displacements_is_loaded_as_it_was_saved() {
        let request = BakeRequest {
            elastic_spacing: Some(0.05),
            crack_spacing: Some(0.05),
            examples: 8,
            elements: ElementChoice::Auto,
            ..BakeRequest::new("plate", "glass", Material::named("glass").unwrap())
        };
        let plate = request.bake(shapes::cuboid([0.4, 0.3, 0.04])).unwrap();
        let own = &plate.report.elastic[0];
        assert!(own.order == ElementOrder::Quadratic && (own.elements_across - 1.6).abs() < 0.05, "{own:?}");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plate.shatter");
        save(&plate, &file).unwrap();
        let loaded = load(&file).unwrap();
        assert_eq!(loaded.report, plate.report);
        let [a, b] = [&plate, &loaded].map(|object| object.bodies[0].solid.as_ref().unwrap());
        assert_eq!((a.elasticity.order(), b.elasticity.order()), (ElementOrder::Quadratic, ElementOrder::Quadratic));
        assert!(a.reduced.is_some() && a.reduced == b.reduced);
        assert!(a.reduced.as_ref().unwrap().modes().is_some() && b.reduced.as_ref().unwrap().mass().is_some());
        assert!(b.reduced.as_ref().unwrap().completed_estimate().is_some());
        let [bound, stored] = [&plate, &loaded].map(|object| object.bodies[0].bound.as_ref().unwrap());
        assert_eq!(bound, stored);
        // The basis holds most of the energy of another contact.
        let reduced = b.reduced.as_ref().unwrap();
        let point = plate.frame.to_local(&Point3::new(0.07, 0.05, 0.02));
        let contact = ContactLoad { point, impulse: -Vector3::z(), radius: 0.1 };
        let (mut load, mut workspace, mut displacement) =
            (NodalLoad::default(), ElasticWorkspace::default(), Vec::new());
        b.elasticity.load(&[contact], &mut load, &mut workspace).unwrap();
        b.elasticity.solve(&load.forces, &mut displacement, &mut workspace, &Default::default()).unwrap();
        let share = reduced.project(&load, &mut Vec::new()) / b.elasticity.elastic_energy(&load.forces, &displacement);
        assert!((0.8..1.0 + 1e-4).contains(&share), "{share}");
    }

    fn quadratic_plate() -> BakeRequest {
        BakeRequest {
            elastic_spacing: Some(0.06),
            crack_spacing: Some(0.06),
            elements: ElementChoice::Quadratic,
            ..BakeRequest::new("plate", "glass", Material::named("glass").unwrap())
        }
    }

    #[test]
    fn quadratic_bodies_of_scenes_without_interior_lift_have_a_basis() {
        let tables = Tables { elastic: true, ..Tables::NONE };
        let request = BakeRequest { tables, ..quadratic_plate() };
        let plate = request.bake(shapes::cuboid([0.4, 0.3, 0.05])).unwrap();
        assert!(plate.bodies[0].lift(LiftKind::Interior).is_none() && plate.reduction.is_some());
    }

    #[test]
    fn a_basis_without_data_to_complete_displacements_is_loaded() {
        let request = quadratic_plate();
        let mut plate = request.bake(shapes::cuboid([0.4, 0.3, 0.05])).unwrap();
        let solid = plate.bodies[0].solid.as_mut().unwrap();
        let basis = solid.reduced.take().unwrap();
        let tables = QuadraticTables { completion: None, ..basis.quadratic().unwrap().clone() };
        let (rows, gram, estimate) = (basis.basis().to_vec(), basis.gram().to_vec(), basis.estimate());
        solid.reduced = Some(ReducedBasis::stored_quadratic(&solid.elasticity, rows, gram, tables, estimate));
        plate.reduction = plate.reduction.map(|own| ReductionErrors { completed: None, ..own });
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("plate.shatter");
        save(&plate, &file).unwrap();
        let loaded = load(&file).unwrap();
        assert!(loaded.reduction == plate.reduction && loaded.reduction.is_some());
        let [a, b] = [&plate, &loaded].map(|object| object.bodies[0].solid.as_ref().unwrap());
        assert!(a.reduced == b.reduced && b.reduced.as_ref().unwrap().completed_estimate().is_none());
    }
    #[test]
    fn masses_that_are_not_positive_are_refused() {
        let file = Trial::of(ElementChoice::default()).file;
        let tensor = "reduced0.mass";
        let masses: Vec<f64> = file.bytes(tensor).as_chunks().0.iter().map(|own| f64::from_le_bytes(*own)).collect();
        let rank = masses.len().isqrt();
        let load = |alter: &dyn Fn(usize, usize, f64) -> f64| {
            load_altered(&file, tensor, |bytes| {
                for (at, own) in bytes.as_chunks_mut().0.iter_mut().enumerate() {
                    *own = alter(at / rank, at % rank, masses[at]).to_le_bytes();
                }
            })
        };
        assert_eq!(load(&|_, _, mass| mass), Ok(()));
        let diagonal = |row: usize| masses[row * rank + row];
        // Three directions that are nearly opposite to each other cannot be.
        let opposite = |row: usize, column: usize, mass: f64| {
            let bound = (diagonal(row) * diagonal(column)).sqrt();
            if row != column && row.max(column) < 3 { -0.9 * bound } else { mass }
        };
        let negative = |row: usize, column: usize, mass: f64| if row == 1 && column == 1 { -mass } else { mass };
        let lopsided = |row: usize, column: usize, mass: f64| if row < column { 0.5 * mass + 1e-12 } else { mass };
        let endless = |row: usize, column: usize, mass: f64| if row == column { f64::INFINITY } else { mass };
        for (what, alter) in [
            ("opposite", &opposite as &dyn Fn(usize, usize, f64) -> f64),
            ("negative", &negative),
            ("lopsided", &lopsided),
            ("endless", &endless),
        ] {
            let error = load(alter).expect_err(what);
            assert!(error.contains(tensor), "{what}: {error}");
        }
    }
}
