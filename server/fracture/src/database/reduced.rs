//! Conversion of reduced bases to tensors, and back.

use super::container::{ContainerContents, FLAT, Tensors};
use super::{DatabaseError, stored_values};
use crate::elasticity::{CompletionTables, Elasticity, ElementOrder, ErrorEstimate, QuadraticTables, ReducedBasis};
use crate::pipeline::{PreparedObject, RANK_MAX};

/// Metadata key of the errors of all bases; absent without bases.
pub(super) const REDUCTION_KEY: &str = "reduction";

/// Name of a tensor of body `index`.
fn name(index: usize, part: &str) -> String {
    format!("reduced{index}.{part}")
}

/// Adds the bases of all bodies that have one.
pub(super) fn put(tensors: &mut Tensors, prepared: &PreparedObject) {
    for (index, body) in prepared.bodies.iter().enumerate() {
        let solid = body.solid.as_ref();
        if let Some((solid, reduced)) = solid.and_then(|solid| Some((solid, solid.reduced.as_ref()?))) {
            let shape = [solid.elasticity.size(), reduced.rank()];
            tensors.f32(name(index, "basis"), &shape, reduced.basis());
            tensors.f64(name(index, "gram"), &[reduced.rank(), reduced.rank()], reduced.gram());
            if let Some(QuadraticTables { strains, weighted, inertial, completion }) = reduced.quadratic() {
                tensors.f32(name(index, "strains"), &[2 * shape[0], shape[1]], strains);
                tensors.f32(name(index, "weighted"), &shape, weighted);
                tensors.f64(name(index, "inertial"), &[QuadraticTables::INERTIAL, shape[1]], inertial);
                if let Some(CompletionTables { forces, estimate }) = completion {
                    tensors.f32(name(index, "forces"), &shape, forces);
                    tensors.f64(name(index, "completed"), &[2], &[estimate.factor, estimate.power]);
                }
            }
            let ErrorEstimate { factor, power } = reduced.estimate();
            tensors.f64(name(index, "estimate"), &[2], &[factor, power]);
        }
    }
}

/// The basis of body `index`; `None` if the file has none.
pub(super) fn reduced(
    contents: &ContainerContents,
    index: usize,
    elasticity: &Elasticity,
) -> Result<Option<ReducedBasis>, DatabaseError> {
    let basis = name(index, "basis");
    if !contents.holds(&basis) {
        return Ok(None);
    }
    let (rank, entries) = contents.f32(&basis, elasticity.size())?;
    if !(1..=RANK_MAX).contains(&rank) {
        return Err(DatabaseError::TooLarge { what: "columns of a basis", found: rank, cap: RANK_MAX });
    }
    stored_values::basis(&basis, &entries)?;
    let estimate = estimate(contents, name(index, "estimate"))?;
    let gram = contents.f64(&name(index, "gram"), Some(rank), rank)?;
    stored_values::gram(&name(index, "gram"), rank, &gram)?;
    if elasticity.order() == ElementOrder::Linear {
        return Ok(Some(ReducedBasis::stored(elasticity, rank, entries, gram, estimate)));
    }
    let tables = quadratic(contents, index, elasticity.size(), &entries, rank)?;
    Ok(Some(ReducedBasis::stored_quadratic(elasticity, entries, gram, tables, estimate)))
}

/// The error model in `tensor`.
fn estimate(contents: &ContainerContents, tensor: String) -> Result<ErrorEstimate, DatabaseError> {
    let fitted = contents.f64(&tensor, Some(2), FLAT)?;
    match fitted.iter().position(|value| *value <= 0.0) {
        Some(index) => Err(DatabaseError::NotPositive { tensor, index, value: fitted[index] }),
        None => Ok(ErrorEstimate { factor: fitted[0], power: fitted[1] }),
    }
}

/// The tables of a basis of quadratic displacements of body `index`, which has `size` unknowns of nodes, and this `basis`.
fn quadratic(
    contents: &ContainerContents,
    index: usize,
    size: usize,
    basis: &[f32],
    rank: usize,
) -> Result<QuadraticTables, DatabaseError> {
    let rows = |part: &str, rows: usize| {
        let tensor = name(index, part);
        let (found, entries) = contents.f32(&tensor, rows)?;
        if found != rank {
            let (found, wanted) = (format!("{found} columns"), format!("{rank}, the rank of the basis"));
            return Err(DatabaseError::Shape { tensor, found, wanted });
        }
        stored_values::basis(&tensor, &entries)?;
        Ok(entries)
    };
    let (strains, weighted) = (rows("strains", 2 * size)?, rows("weighted", size)?);
    let inertial = contents.f64(&name(index, "inertial"), Some(QuadraticTables::INERTIAL), rank)?;
    stored_values::inertial(&name(index, "inertial"), rank, &inertial, [basis, &weighted])?;
    // Files of earlier versions have none.
    let completion = if contents.holds(&name(index, "forces")) {
        Some(CompletionTables {
            forces: rows("forces", size)?,
            estimate: estimate(contents, name(index, "completed"))?,
        })
    } else {
        None
    };
    Ok(QuadraticTables { strains, weighted, inertial, completion })
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
