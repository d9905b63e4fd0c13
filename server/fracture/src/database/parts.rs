//! Parts of an object that a lattice loses, tears off, or leaves without elasticity: named in the defect report.

use crate::lattice::Levels;
use crate::surface::{Defect, DefectKind, Inside, Part, Surface};
use nalgebra::Point3;

/// Bodies beyond the input's own parts.
pub(super) fn severed(surface: &Surface, levels: &Levels) -> Option<Defect> {
    let own = surface.parts.len().max(1);
    let more = levels.bodies.len().checked_sub(own).filter(|more| *more > 0)?;
    let action = "bodies of their own: joined by less than the lattice resolves; try a finer --crack-spacing";
    Some(Defect::new(DefectKind::SeveredPart, more as u64, surface.parts.first().map_or(0, |part| part.face), action))
}

/// Crack nodes that no elastic lattice is near.
pub(super) fn far(inside: &Inside, levels: &Levels) -> Option<Defect> {
    let first = inside.nearest_face(levels.far.first()?);
    let action = "solved on the nearest part: limbs thinner than the elastic spacing; try a finer --elastic-spacing";
    Some(Defect::new(DefectKind::CoarseElastic, levels.far.len() as u64, first, action))
}

/// Components that the crack lattice could not keep, with their share of the volume: those that it dropped, and shells in
/// whose box it has no node.
pub(super) fn dropped(inside: &Inside, surface: &Surface, volume: f64, levels: &Levels) -> Option<Defect> {
    let nodes = || levels.bodies.iter().flat_map(|body| &body.crack.nodes);
    let holds = |part: &Part, node: &Point3<f64>| (0..3).all(|k| (part.low[k]..=part.high[k]).contains(&node[k]));
    let missed: Vec<&Part> = surface
        .parts
        .iter()
        .filter(|part| !nodes().any(|node| holds(part, node)))
        .filter(|part| !levels.crack.dropped.iter().any(|dropped| holds(part, &dropped.place)))
        .collect();
    let dropped = &levels.crack.dropped;
    let first = match (dropped.first(), missed.first()) {
        (Some(dropped), _) => inside.nearest_face(&dropped.place),
        (None, Some(part)) => part.face,
        (None, None) => return None,
    };
    let gone = dropped.iter().map(|component| component.volume).chain(missed.iter().map(|part| part.volume));
    let lost: f64 = gone.sum();
    let (share, lost_m3) = (100.0 * lost / volume, lost * surface.frame.diagonal_m.powi(3));
    let action = format!("left out: smaller than the lattice spacing, {lost_m3:.3e} m³, {share:.4} % of the volume");
    Some(Defect::new(DefectKind::DroppedComponent, (dropped.len() + missed.len()) as u64, first, action))
}
