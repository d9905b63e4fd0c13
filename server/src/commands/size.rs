//! Plausibility of a mesh's size: detects files in another length unit.

use nalgebra::Vector3;
use shatter_fracture::surface::{LengthUnit, RawMesh};

/// Extents without a warning, m; larger ones are buildings, smaller ones grains.
const LIKELY_M: std::ops::Range<f64> = 1e-3..5.0;

/// Extents without a warning if the unit was given on the command line, m.
const LIKELY_WITH_UNIT_M: std::ops::Range<f64> = 5e-3..100.0;

/// Mass from which a bake warns, kg.
const HEAVY_KG: f64 = 5e3;

/// Extents of handheld and furniture-sized objects, m; the warning suggests units that lead to such an extent.
const USUAL_M: std::ops::RangeInclusive<f64> = 0.02..=3.0;

/// Warning about the size of `mesh`, which was read in `given`, or in meters if no unit was given; `None` if the size is plausible.
pub fn doubtful(mesh: &RawMesh, given: Option<LengthUnit>, density_kg_m3: f64) -> Option<String> {
    let unit = given.unwrap_or(LengthUnit::M);
    let [low, high] = corners(mesh)?;
    let size_m = (high - low).max();
    let mass_kg = volume(mesh, &(0.5 * (low + high))) * density_kg_m3;
    let is_likely = match given {
        None => LIKELY_M.contains(&size_m) && mass_kg < HEAVY_KG,
        Some(_) => LIKELY_WITH_UNIT_M.contains(&size_m),
    };
    if !size_m.is_finite() || size_m == 0.0 || is_likely {
        return None;
    }
    let others = LengthUnit::ALL.into_iter().filter(|other| *other != unit).filter_map(|other| {
        let factor = other.meters() / unit.meters();
        let (size_m, mass_kg) = (size_m * factor, mass_kg * factor.powi(3));
        USUAL_M.contains(&size_m).then(|| format!("with --unit {other} it would be {}", measured(size_m, mass_kg)))
    });
    let others: Vec<String> = others.collect();
    let advice = if others.is_empty() { "check --unit".to_owned() } else { others.join(", ") };
    let suppressing_option = match given {
        None if LIKELY_WITH_UNIT_M.contains(&size_m) => format!("; --unit {unit} keeps this size without a warning"),
        _ => String::new(),
    };
    Some(format!("the mesh is {} (unit {unit}); {advice}{suppressing_option}", measured(size_m, mass_kg)))
}

/// Diagonal of the bounding box of `mesh`, m; 0 without vertices.
pub fn diagonal_m(mesh: &RawMesh) -> f64 {
    corners(mesh).map_or(0.0, |[low, high]| (high - low).norm())
}

/// Lowest and highest coordinates of the triangles of `mesh` that have an area, m; `None` without such triangles.
fn corners(mesh: &RawMesh) -> Option<[Vector3<f64>; 2]> {
    let at = |own: &[u32; 3]| own.map(|vertex| mesh.positions_m.get(vertex as usize).map(|point| point.coords));
    let has_area = |[a, b, c]: &[Vector3<f64>; 3]| (b - a).cross(&(c - a)) != Vector3::zeros();
    let triangles = mesh.triangles.iter().filter_map(|own| match at(own) {
        [Some(a), Some(b), Some(c)] => Some([a, b, c]).filter(has_area),
        _ => None,
    });
    let corners: Vec<Vector3<f64>> = triangles.flatten().collect();
    let points = || corners.iter().copied();
    Some([points().reduce(|a, b| a.inf(&b))?, points().reduce(|a, b| a.sup(&b))?])
}

fn measured(size_m: f64, mass_kg: f64) -> String {
    format!("{} m large and {} kg", significant(size_m), significant(mass_kg))
}

/// Formats with two digits, or with all digits before the decimal point.
pub(super) fn rounded(value: f64) -> String {
    if value < 10.0 { format!("{value:.1}") } else { format!("{value:.0}") }
}

/// Formats with three digits, and with a power of ten if the number is long.
fn significant(value: f64) -> String {
    if !(1e-3..1e4).contains(&value) {
        return format!("{value:.2e}");
    }
    let digits = (2 - value.log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

/// Volume by the divergence theorem, m³; exact for closed surfaces.
fn volume(mesh: &RawMesh, middle: &Vector3<f64>) -> f64 {
    let corner = |vertex: u32| mesh.positions_m.get(vertex as usize).map_or(*middle, |point| point.coords) - middle;
    let cone = |[a, b, c]: &[u32; 3]| corner(*a).dot(&corner(*b).cross(&corner(*c))) / 6.0;
    mesh.triangles.iter().map(cone).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use shatter_fracture::surface::shapes;

    #[test]
    fn a_mesh_in_millimeters_is_asked_about_and_others_are_not() {
        let in_millimeters = shapes::cuboid([300.0, 658.0, 200.0]);
        let message = doubtful(&in_millimeters, None, 2500.0).unwrap();
        assert!(message.contains("658 m large and 9.87e10 kg (unit m)"), "{message}");
        assert!(message.contains("with --unit mm it would be 0.658 m large and 98.7 kg"), "{message}");
        assert!(!message.contains("--unit cm") && !message.contains("keeps"), "--unit m would warn, too: {message}");
        assert!(doubtful(&in_millimeters, Some(LengthUnit::M), 2500.0).is_some());
        assert_eq!(doubtful(&shapes::cuboid([0.3, 0.658, 0.2]), Some(LengthUnit::Mm), 2500.0), None);
        let tiny = doubtful(&shapes::cuboid([2e-4, 1e-4, 1e-4]), Some(LengthUnit::Mm), 2500.0).unwrap();
        assert!(tiny.contains("with --unit m it would be 0.200 m"), "{tiny}");
        let small = doubtful(&shapes::cuboid([1.8e-3, 1e-3, 1e-3]), Some(LengthUnit::Mm), 2500.0).unwrap();
        assert!(small.contains("(unit mm); with --unit m it would be 1.80 m") && !small.contains("keeps"), "{small}");
        let large_box = doubtful(&shapes::cuboid([10.0, 2.0, 2.0]), None, 2500.0).unwrap();
        assert!(large_box.contains("10.0 m large and 1.00e5 kg"), "{large_box}");
        let block = doubtful(&shapes::cuboid([2.0, 2.0, 2.0]), None, 2500.0).unwrap();
        assert!(block.contains("with --unit cm it would be 0.0200 m") && block.contains("--unit m keeps"), "{block}");
        assert_eq!(doubtful(&shapes::cuboid([2.0, 0.75, 1.0]), None, 750.0), None, "a table");
        let mut with_far_vertices = shapes::cuboid([0.3, 0.658, 0.2]);
        let first = with_far_vertices.positions_m.len() as u32;
        with_far_vertices.positions_m.extend([Point3::new(1e9, 0.0, 0.0), Point3::new(0.0, 1e9, 0.0)]);
        with_far_vertices.triangles.push([first, first, 0]);
        assert_eq!(doubtful(&with_far_vertices, None, 2500.0), None, "no triangle with an area uses them");
    }
}
