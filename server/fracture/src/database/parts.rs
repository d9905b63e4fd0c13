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

/// Components that the crack lattice could not keep: those that it dropped, and shells in whose box it has no node.
pub(super) struct Gone {
    /// How many.
    pub count: u64,
    /// Their volume, local.
    pub volume: f64,
    /// A place in the first that was dropped, or else a face of the first that was missed.
    first: Option<First>,
}

enum First {
    Place(Point3<f64>),
    Face(u64),
}

/// What the crack lattice could not keep of a shape of `volume` (local).
///
/// Where the lattice swells to meet the volume, what it dropped has swollen too: its share counts, not its size.
pub(super) fn gone(surface: &Surface, levels: &Levels, volume: f64) -> Gone {
    let nodes = || levels.bodies.iter().flat_map(|body| &body.crack.nodes);
    let holds = |part: &Part, node: &Point3<f64>| (0..3).all(|k| (part.low[k]..=part.high[k]).contains(&node[k]));
    let dropped = &levels.crack.dropped;
    let missed: Vec<&Part> = surface
        .parts
        .iter()
        .filter(|part| !nodes().any(|node| holds(part, node)))
        .filter(|part| !dropped.iter().any(|dropped| holds(part, &dropped.place)))
        .collect();
    let dropped_volume: f64 = dropped.iter().map(|component| component.volume).sum();
    let missed_volume: f64 = missed.iter().map(|part| part.volume).sum();
    let dropped_share = dropped_volume / (dropped_volume + levels.crack.volume);
    let place = dropped.first().map(|dropped| First::Place(dropped.place));
    Gone {
        count: (dropped.len() + missed.len()) as u64,
        volume: missed_volume + dropped_share * (volume - missed_volume).max(0.0),
        first: place.or(missed.first().map(|part| First::Face(part.face))),
    }
}

impl Gone {
    /// The line of the defect report, with the share of the input's volume.
    pub fn defect(&self, inside: &Inside, surface: &Surface, volume: f64) -> Option<Defect> {
        let first = match self.first.as_ref()? {
            First::Place(place) => inside.nearest_face(place),
            First::Face(face) => *face,
        };
        let (share, lost_m3) = (100.0 * self.volume / volume, self.volume * surface.frame.diagonal_m.powi(3));
        let action =
            format!("left out: smaller than the lattice spacing, {lost_m3:.3e} m³, {share:.4} % of the volume");
        Some(Defect::new(DefectKind::DroppedComponent, self.count, first, action))
    }
}

/// Area of the surface, local.
pub(super) fn area(surface: &Surface) -> f64 {
    let triangle = |triangle| {
        let [a, b, c] = surface.corners(triangle);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    (0..surface.triangles.len()).map(triangle).sum()
}
