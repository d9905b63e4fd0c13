//! Conversion of reduced bases to tensors, and back.

use super::container::{ContainerContents, FLAT, Tensors};
use super::{DatabaseError, stored_values};
use crate::elasticity::{Elasticity, ErrorEstimate, ReducedBasis};
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
    let tensor = name(index, "estimate");
    let fitted = contents.f64(&tensor, Some(2), FLAT)?;
    if let Some(index) = fitted.iter().position(|value| *value <= 0.0) {
        return Err(DatabaseError::NotPositive { tensor, index, value: fitted[index] });
    }
    let estimate = ErrorEstimate { factor: fitted[0], power: fitted[1] };
    let gram = contents.f64(&name(index, "gram"), Some(rank), rank)?;
    stored_values::gram(&name(index, "gram"), rank, &gram)?;
    Ok(Some(ReducedBasis::stored(elasticity, rank, entries, gram, estimate)))
}
