//! Checks of values in a database beyond shapes and index ranges.
//!
//! A file that no bake would write is rejected with the name of the value, even if its checksums match.

use super::DatabaseError;
use super::object_name::is_object_name;
use super::wall_limits::STRETCH_MAX;
use crate::cutting::{CuttingMesh, LISTED_MAX};
use crate::degree;
use crate::lattice::{EnergyTransfer, Lattice, LatticeStretch};
use crate::lift::MODES_MAX;
use crate::pipeline::{
    BakeParameters, BakeReport, CELLS_MAX, LearnedErrors, PreparedBody, PreparedObject, ReductionErrors, SurfaceKind,
    SurfaceReport,
};
use crate::surface::{DIAGONAL_RANGE_M, LocalFrame, UV_MAX};
use std::ops::RangeInclusive;

/// Largest coordinate of a lattice or a skin, local. The input's bounding box has diagonal 1 and its center at the
/// origin.
const COORDINATE_MAX: f64 = 1.0;

/// Largest coordinate of a lift, local. Lifts are scaled to distances within the object.
const LIFT_MAX: f64 = 1e6;

/// Largest entry of a reduced basis, local. Its squares and products stay finite in single precision.
const BASIS_MAX: f32 = 1e12;

/// Largest work of a displacement with the inertial forces of a unit acceleration, over its largest entry, local.
/// Measured: 0.03 on the mug, 0.01 on the statue.
const WORK_MAX: f64 = 1.0;

/// Relative rounding error allowed in a sum. Measured: sums of 60,000 shares were off by 1e-13.
const SUM_TOLERANCE: f64 = 1e-9;

/// Relative difference allowed between the stored volume and that of the lattices.
///
/// Slots of existing cracks are subtracted from a stored sum.
const VOLUME_TOLERANCE: f64 = 1e-6;

/// Ratio of the lattices' volume to that of the input. A bake fails if it loses too large a share.
const VOLUME_RATIO: RangeInclusive<f64> = 0.1..=10.0;

/// Allowed ratios of a given number to its usual value, wide enough for extreme objects and narrow enough to detect
/// wrong units.
pub(super) const RATIOS: RangeInclusive<f64> = 1e-18..=1e18;

/// Allowed length of a normal: unit vectors, stored in single precision and interpolated.
const NORMAL_LENGTH: RangeInclusive<f64> = 0.9..=1.1;

/// Largest relative error in a report.
const ERROR_MAX: f64 = 1e9;

/// Checks that all `values` fit; the error names the first that does not.
pub(super) fn all<T: Copy + Into<f64>>(
    tensor: &str,
    values: &[T],
    wanted: &'static str,
    fits: impl Fn(f64) -> bool,
) -> Result<(), DatabaseError> {
    match values.iter().position(|value| !fits((*value).into())) {
        Some(index) => Err(implausible(tensor, index, values[index].into(), wanted)),
        None => Ok(()),
    }
}

/// The error for an entry that no bake writes.
pub(super) fn implausible(tensor: &str, index: usize, value: f64, wanted: &'static str) -> DatabaseError {
    DatabaseError::Implausible { tensor: tensor.to_owned(), index, value, wanted }
}

/// Checks coordinates of nodes or points, local.
pub(super) fn coordinates(tensor: &str, values: &[f64]) -> Result<(), DatabaseError> {
    all(tensor, values, "within the object's box", |value| value.abs() <= COORDINATE_MAX)
}

/// Checks points of a skin: inside the sphere around the input's bounding box, which has diagonal 1, plus one
/// `spacing`.
///
/// The margin is for walls of cracks. The points are not compared to the lattice, which loses details thinner than its
/// spacing.
pub(super) fn points(tensor: &str, values: &[[f64; 3]], spacing: f64) -> Result<(), DatabaseError> {
    let radius = |point: &[f64; 3]| point.iter().map(|x| x * x).sum::<f64>().sqrt();
    match values.iter().position(|point| radius(point) > 0.5 + spacing) {
        Some(row) => Err(implausible(
            tensor,
            3 * row,
            radius(&values[row]),
            "a distance from the middle within the object's box",
        )),
        None => Ok(()),
    }
}

/// Checks a bound of E_1 against the ranges that stiffness and lifts allow. Zero marks an unknown first-moment bound.
pub(super) fn bound(tensor: &str, values: &[f64; 4], ranges: &[RangeInclusive<f64>; 4]) -> Result<(), DatabaseError> {
    let wrong = |&index: &usize| !(ranges[index].contains(&values[index]) || (index > 0 && values[index] == 0.0));
    match (0..values.len()).find(wrong) {
        Some(index) => Err(implausible(tensor, index, values[index], "a bound of this body's elasticity")),
        None => Ok(()),
    }
}

/// A given number in relation to its usual value.
pub(super) struct PlausibleRange {
    /// Name of the number.
    pub key: &'static str,
    /// Usual value, in words.
    pub over: &'static str,
    /// Ratio of the number to the usual value.
    pub value: f64,
}

/// The first number of an object in `frame` whose ratio to its usual value is outside [`RATIOS`].
///
/// Usual values: the diagonal for the fragment size, the reference γ of material and fragment size for γ, 1 for κ.
pub(super) fn unusual(own: &BakeParameters, frame: &LocalFrame, gamma_j_m2: f64, kappa: f64) -> Option<PlausibleRange> {
    let BakeParameters { material, fragment_size_m, .. } = own;
    let reference = degree::reference_gamma(material.young_pa, material.strength_pa, *fragment_size_m);
    let all = [
        PlausibleRange {
            key: "fragment_size_m",
            over: "the diagonal of the shape",
            value: fragment_size_m / frame.diagonal_m,
        },
        PlausibleRange { key: "gamma_j_m2", over: "that of material and fragment size", value: gamma_j_m2 / reference },
        PlausibleRange { key: "kappa", over: "1", value: kappa },
    ];
    all.into_iter().find(|ratio| !RATIOS.contains(&ratio.value))
}

/// Checks fragment size, γ and κ against their usual values.
pub(super) fn usual(
    own: &BakeParameters,
    frame: &LocalFrame,
    gamma_j_m2: f64,
    kappa: f64,
) -> Result<(), DatabaseError> {
    unusual(own, frame, gamma_j_m2, kappa).map_or(Ok(()), |PlausibleRange { key, over, value }| {
        let part = if key == "fragment_size_m" { "parameters" } else { "shape" };
        Err(metadata(
            part,
            format!("{key} is {value:e} times {over}, must be {:e} to {:e} times", RATIOS.start(), RATIOS.end()),
        ))
    })
}

/// Checks coordinates of a lift.
pub(super) fn lift(tensor: &str, values: &[f64]) -> Result<(), DatabaseError> {
    all(tensor, values, "a distance within the object", |value| value.abs() <= LIFT_MAX)
}

/// Checks entries of a reduced basis.
pub(super) fn basis(tensor: &str, values: &[f32]) -> Result<(), DatabaseError> {
    all(tensor, values, "a displacement of unit energy", |value| value.abs() <= f64::from(BASIS_MAX))
}

/// Checks the work of a basis with inertial forces, one row of `rank` entries per acceleration, by the largest of the
/// `displacements` of each column: the object's volume and all arms are below one.
pub(super) fn inertial(
    tensor: &str,
    rank: usize,
    values: &[f64],
    displacements: [&[f32]; 2],
) -> Result<(), DatabaseError> {
    let largest = displacements.map(|rows| {
        let mut largest = vec![0.0f64; rank];
        for row in rows.chunks_exact(rank) {
            largest.iter_mut().zip(row).for_each(|(largest, own)| *largest = largest.max(f64::from(own.abs())));
        }
        largest
    });
    let half = values.len() / 2;
    let most = |index: usize| WORK_MAX * largest[index / half][index % rank];
    match (0..values.len()).find(|&index| values[index].abs() > most(index)) {
        Some(index) => Err(implausible(tensor, index, values[index], "the work of a displacement with its inertia")),
        None => Ok(()),
    }
}

/// Checks texture coordinates.
pub(super) fn uvs(tensor: &str, values: &[[f32; 2]]) -> Result<(), DatabaseError> {
    all(tensor, values.as_flattened(), "a texture coordinate", |value| value.abs() <= f64::from(UV_MAX))
}

/// Checks that normals have unit length.
pub(super) fn normals(tensor: &str, values: &[[f32; 3]]) -> Result<(), DatabaseError> {
    let length = |normal: &[f32; 3]| normal.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    match values.iter().position(|normal| !NORMAL_LENGTH.contains(&length(normal))) {
        Some(row) => Err(implausible(tensor, 3 * row, length(&values[row]), "a normal of length one")),
        None => Ok(()),
    }
}

/// Checks barycentric coordinates: not negative, and each four add up to 1.
pub(super) fn weights(tensor: &str, values: &[[f64; 4]]) -> Result<(), DatabaseError> {
    let fits = |own: &[f64; 4]| {
        (own.iter().sum::<f64>() - 1.0).abs() <= SUM_TOLERANCE && own.iter().all(|weight| *weight >= -SUM_TOLERANCE)
    };
    match values.iter().position(|own| !fits(own)) {
        Some(row) => Err(implausible(tensor, 4 * row, values[row].iter().sum(), "four weights that add up to one")),
        None => Ok(()),
    }
}

/// Checks a Gram matrix: symmetric, with entries within the Cauchy–Schwarz bound.
pub(super) fn gram(tensor: &str, rank: usize, values: &[f64]) -> Result<(), DatabaseError> {
    let at = |i: usize, j: usize| values[i * rank + j];
    let wrong = |&(i, j): &(usize, usize)| {
        let most = (at(i, i) * at(j, j)).sqrt() * (1.0 + SUM_TOLERANCE);
        let fits = at(i, i) > 0.0 && at(i, j).abs() <= most && (at(i, j) - at(j, i)).abs() <= SUM_TOLERANCE * most;
        !fits
    };
    match (0..rank).flat_map(|i| (0..rank).map(move |j| (i, j))).find(wrong) {
        Some((i, j)) => Err(implausible(tensor, i * rank + j, at(i, j), "an entry of a symmetric matrix of products")),
        None => Ok(()),
    }
}

/// Checks that each row of a transfer names each tetrahedron once, in ascending order.
pub(super) fn rows(tensor: &str, transfer: &EnergyTransfer) -> Result<(), DatabaseError> {
    let falls = |row: &[u32]| {
        let first = row[0] as usize;
        let own = &transfer.tets[first..row[1] as usize];
        own.windows(2).position(|pair| pair[1] <= pair[0]).map(|index| first + index + 1)
    };
    match transfer.offsets.windows(2).enumerate().find_map(|(row, ends)| Some((row, falls(ends)?))) {
        Some((row, index)) => {
            let value = f64::from(transfer.tets[index]);
            Err(implausible(tensor, row, value, "a row of tetrahedra in ascending order"))
        }
        None => Ok(()),
    }
}

/// Checks shares: positive, and those of each elastic tetrahedron add up to 1, so that energy is conserved.
pub(super) fn shares(tensor: &str, transfer: &EnergyTransfer, elastic: &Lattice) -> Result<(), DatabaseError> {
    all(tensor, &transfer.shares, "a positive share", |share| share > 0.0 && share <= 1.0 + SUM_TOLERANCE)?;
    let mut sums = vec![0.0; elastic.tets.len()];
    transfer.tets.iter().zip(&transfer.shares).for_each(|(tet, share)| sums[*tet as usize] += share);
    match sums.iter().position(|sum| (sum - 1.0).abs() > SUM_TOLERANCE) {
        Some(tet) => Err(DatabaseError::Shares { tensor: tensor.to_owned(), tet, sum: sums[tet] }),
        None => Ok(()),
    }
}

/// The error for a metadata key with a value that no bake writes.
fn metadata(key: &'static str, reason: String) -> DatabaseError {
    DatabaseError::Metadata { key, reason }
}

/// Checks that numbers are in their ranges; the error names the first that is not.
fn numbers(key: &'static str, all: &[(&str, f64, RangeInclusive<f64>)]) -> Result<(), DatabaseError> {
    match all.iter().find(|(_, value, range)| !range.contains(value)) {
        Some((name, value, range)) => {
            let reason = format!("{name} is {value:e}, must be {:e} to {:e}", range.start(), range.end());
            Err(metadata(key, reason))
        }
        None => Ok(()),
    }
}

/// Range of positive normal numbers.
const POSITIVE: RangeInclusive<f64> = f64::MIN_POSITIVE..=f64::MAX;

/// Range of zero and positive numbers.
const COUNTED: RangeInclusive<f64> = 0.0..=f64::MAX;

/// Range of the length of a unit vector.
const UNIT: RangeInclusive<f64> = 1.0 - 1e-9..=1.0 + 1e-9;

/// Checks the object's name and bake parameters.
pub(super) fn parameters(name: &str, own: &BakeParameters) -> Result<(), DatabaseError> {
    if !is_object_name(name) {
        return Err(metadata("object", "cannot name an object".to_owned()));
    }
    if let Err((key, value)) = own.material.check() {
        return Err(metadata("parameters", format!("material.{key} is {value:e}")));
    }
    let all = [
        ("fragment_size_m", own.fragment_size_m, POSITIVE),
        ("elastic_spacing", own.elastic_spacing, f64::MIN_POSITIVE..=COORDINATE_MAX),
        ("crack_spacing", own.crack_spacing, f64::MIN_POSITIVE..=COORDINATE_MAX),
        ("modes", own.modes as f64, 0.0..=MODES_MAX as f64),
        ("alpha", own.alpha, 0.0..=LIFT_MAX),
    ];
    numbers("parameters", &all)
}

/// Checks the position and size of the object.
pub(super) fn frame(own: &LocalFrame) -> Result<(), DatabaseError> {
    let most = *DIAGONAL_RANGE_M.end();
    let all = [
        ("frame.diagonal_m", own.diagonal_m, DIAGONAL_RANGE_M),
        ("frame.center_m[0]", own.center_m.x, -most..=most),
        ("frame.center_m[1]", own.center_m.y, -most..=most),
        ("frame.center_m[2]", own.center_m.z, -most..=most),
    ];
    numbers("shape", &all)
}

/// Checks the report of a bake against the lattices.
pub(super) fn report(own: &BakeReport, frame: &LocalFrame, bodies: &[PreparedBody]) -> Result<(), DatabaseError> {
    let all = [
        ("input_volume_m3", own.input_volume_m3, POSITIVE),
        ("lattice_volume_m3", own.lattice_volume_m3, POSITIVE),
        ("surface_deviation", own.surface_deviation, 0.0..=COORDINATE_MAX),
        ("lattice_volume_m3 over input_volume_m3", own.volume_error() + 1.0, VOLUME_RATIO),
    ];
    numbers("report", &all)?;
    if ![0, bodies.len()].contains(&own.elastic.len()) {
        return Err(metadata(
            "report",
            format!("elastic has {} entries, must have {}", own.elastic.len(), bodies.len()),
        ));
    }
    for elastic in &own.elastic {
        numbers("report", &[("elements_across", elastic.elements_across, f64::MIN_POSITIVE..=CELLS_MAX)])?;
        let [own, linear] = [elastic.discretization_error, elastic.linear_error].map(|error| error.unwrap_or(0.0));
        let errors = [("discretisation_error", own, 0.0..=1.0), ("linear_discretisation_error", linear, 0.0..=1.0)];
        numbers("report", &errors)?;
    }
    if let Some(LatticeStretch { axis, factor }) = &own.stretch {
        let length = axis.iter().map(|own| own * own).sum::<f64>();
        let all = [("stretch.factor", *factor, 1.0..=STRETCH_MAX), ("the square of stretch.axis", length, UNIT)];
        numbers("report", &all)?;
    }
    if let Some(cracks) = &own.cracks {
        let all = [
            ("cracks.area_m2", cracks.area_m2, COUNTED),
            ("cracks.width_m", cracks.width_m, COUNTED),
            ("cracks.elastic_width_m", cracks.elastic_width_m, COUNTED),
            ("cracks.volume_m3", cracks.volume_m3, COUNTED),
        ];
        numbers("report", &all)?;
    }
    if let Some(absent) = own.unprepared.iter().find(|absent| absent.body >= bodies.len()) {
        return Err(metadata("report", format!("unprepared names body {} of {}", absent.body, bodies.len())));
    }
    let local: f64 = bodies.iter().map(|body| body.crack.volume()).sum();
    let found = local * frame.diagonal_m.powi(3);
    cut_volume(own, frame, bodies)?;
    surface(&own.surface, bodies)?;
    if (found - own.lattice_volume_m3).abs() <= VOLUME_TOLERANCE * own.lattice_volume_m3 {
        return Ok(());
    }
    let reason = format!("lattice_volume_m3 is {:e}, the lattices hold {found:e}", own.lattice_volume_m3);
    Err(metadata("report", reason))
}

/// Checks what a report says of the surface against the meshes of the input surface.
fn surface(own: &SurfaceReport, bodies: &[PreparedBody]) -> Result<(), DatabaseError> {
    let meshes: Vec<&CuttingMesh> = bodies.iter().filter_map(|body| body.cutting.as_ref()).collect();
    let sum = |of: fn(&CuttingMesh) -> usize| meshes.iter().map(|mesh| of(mesh) as u64).sum::<u64>();
    let found = [sum(|own| own.mesh.nodes.len()), sum(|own| own.mesh.tets.len()), sum(CuttingMesh::anchored_count)];
    let stated = [own.nodes, own.tets, own.anchored_nodes];
    if (own.kind == SurfaceKind::Exact) == meshes.is_empty() || found != stated {
        let reason = format!(
            "surface is {} of {stated:?} nodes, tetrahedra and anchored nodes, the file has {found:?}",
            own.kind.name()
        );
        return Err(metadata("report", reason));
    }
    numbers("report", &[("surface.deviation", own.deviation, 0.0..=COORDINATE_MAX)])?;
    for repair in &own.repairs {
        numbers("report", &[("surface.repairs.area_m2", repair.area_m2, 0.0..=f64::MAX)])?;
        numbers("report", &[("surface.repairs.area_share", repair.area_share, 0.0..=1.0)])?;
        if repair.places_m.is_empty() || repair.places_m.len() as u64 > repair.count.min(LISTED_MAX as u64) {
            let reason = format!("surface.repairs has {} places of {}", repair.places_m.len(), repair.count);
            return Err(metadata("report", reason));
        }
    }
    Ok(())
}

/// Checks that the meshes of the input surface, if there are any, have the volume of the input.
fn cut_volume(own: &BakeReport, frame: &LocalFrame, bodies: &[PreparedBody]) -> Result<(), DatabaseError> {
    let volumes: Vec<f64> = bodies.iter().filter_map(|body| Some(body.cutting.as_ref()?.mesh.volume())).collect();
    let found = volumes.iter().sum::<f64>() * frame.diagonal_m.powi(3);
    let wanted = own.input_volume_m3;
    if volumes.is_empty() || (volumes.len() == bodies.len() && (found - wanted).abs() <= VOLUME_TOLERANCE * wanted) {
        return Ok(());
    }
    Err(metadata("report", format!("input_volume_m3 is {wanted:e}, the cutting meshes hold {found:e}")))
}

/// Checks the errors of the learned model.
pub(super) fn quality(own: &LearnedErrors) -> Result<(), DatabaseError> {
    let all = [
        ("median_relative_error", own.median_relative_error, 0.0..=ERROR_MAX),
        ("p90_relative_error", own.p90_relative_error, 0.0..=ERROR_MAX),
        ("closed_form_median", own.closed_form_median, 0.0..=ERROR_MAX),
        ("closed_form_p90", own.closed_form_p90, 0.0..=ERROR_MAX),
        ("pose_network_median", own.pose_network_median, 0.0..=ERROR_MAX),
        ("pose_network_p90", own.pose_network_p90, 0.0..=ERROR_MAX),
        ("few_within_one", own.few_within_one.unwrap_or(0.0), 0.0..=1.0),
        ("label_noise_median", own.label_noise_median, 0.0..=ERROR_MAX),
    ];
    numbers("learned", &all)
}

/// Checks the errors of the reduced bases against the bases.
pub(super) fn reduction(own: &ReductionErrors, bodies: &[PreparedBody]) -> Result<(), DatabaseError> {
    let all = [
        ("energy_error_median", own.energy_error_median, 0.0..=ERROR_MAX),
        ("energy_error_p90", own.energy_error_p90, 0.0..=ERROR_MAX),
        ("density_error_median", own.density_error_median, 0.0..=ERROR_MAX),
        ("degree_error_median", own.degree_error_median, 0.0..=ERROR_MAX),
        ("estimates_within_3", own.estimates_within_3, 0.0..=1.0),
        ("solved", own.solved, 0.0..=1.0),
    ];
    numbers("reduction", &all)?;
    if let Some(own) = &own.completed {
        let all = [
            ("energy_error_median", own.energy_error_median, 0.0..=ERROR_MAX),
            ("energy_error_p90", own.energy_error_p90, 0.0..=ERROR_MAX),
            ("density_error_median", own.density_error_median, 0.0..=ERROR_MAX),
        ];
        numbers("reduction.completed", &all)?;
    }
    if own.rank.len() != bodies.len() {
        return Err(metadata("reduction", format!("{} ranks of {} bodies", own.rank.len(), bodies.len())));
    }
    let differs = |(rank, body): (&usize, &PreparedBody)| {
        body.solid.is_some() && body.reduced().map_or(0, |own| own.rank()) != *rank
    };
    match own.rank.iter().zip(bodies).position(differs) {
        Some(index) => Err(metadata("reduction", format!("rank[{index}] is not that of the basis"))),
        None => Ok(()),
    }
}

/// Checks that every example belongs to a drawn impact.
pub(super) fn impacts(own: &PreparedObject) -> Result<(), DatabaseError> {
    let last = own.examples.iter().map(|example| example.impact).max();
    match last.filter(|last| *last >= own.impacts) {
        Some(last) => {
            Err(metadata("shape", format!("impacts is {}, but examples.heads names impact {last}", own.impacts)))
        }
        None => Ok(()),
    }
}

/// Checks that materials of triangles are named in the report, or `none`.
pub(super) fn materials(tensor: &str, own: &[u32], names: usize, none: u32) -> Result<(), DatabaseError> {
    match own.iter().position(|material| *material != none && *material as usize >= names) {
        Some(index) => {
            let (value, limit) = (u64::from(own[index]), names as u64);
            Err(DatabaseError::OutOfRange { tensor: tensor.to_owned(), index, value, limit })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::database::{BakeRequest, Tables, bake};
    use crate::pipeline::{DisplacementMethod, ElementChoice, SurfaceKind};
    use crate::scene::Material;
    use crate::surface::shapes;

    #[test]
    fn errors_of_lattices_are_shares() {
        let request = BakeRequest {
            elements: ElementChoice::Quadratic,
            elastic: DisplacementMethod::Solve,
            surface: SurfaceKind::Lattice,
            tables: Tables { elastic: true, ..Tables::NONE },
            elastic_spacing: Some(0.2),
            crack_spacing: Some(0.2),
            ..BakeRequest::new("block", "glass", Material::named("glass").unwrap())
        };
        let mut prepared =
            bake(shapes::cuboid([0.5, 0.4, 0.3]), &request, &CancelToken::default(), &mut |_| ()).unwrap();
        let own = prepared.report.elastic[0].clone();
        assert!(own.discretization_error.unwrap() > 0.0 && own.linear_error > own.discretization_error, "{own:?}");
        let text = serde_json::to_value(&own).unwrap();
        assert_eq!(text["linear_discretisation_error"].as_f64(), own.linear_error);
        report(&prepared.report, &prepared.frame, &prepared.bodies).unwrap();
        for (name, errors) in [("discretisation_error", [1.5, 0.5]), ("linear_discretisation_error", [0.5, -0.1])] {
            let elastic = &mut prepared.report.elastic[0];
            (elastic.discretization_error, elastic.linear_error) = (Some(errors[0]), Some(errors[1]));
            let error = report(&prepared.report, &prepared.frame, &prepared.bodies).unwrap_err().to_string();
            assert!(error.contains(&format!("{name} ")), "{error}");
        }
    }
}
