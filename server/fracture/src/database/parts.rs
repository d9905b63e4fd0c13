//! Parts of an object that a lattice loses, tears off, or leaves without elasticity: named in the defect report.

use super::bake::BakeError;
use crate::lattice::{CRACK_NODES_MAX, Levels, Spacings};
use crate::surface::{Defect, DefectKind, Inside, Part, Surface};
use nalgebra::Point3;

/// What is left of the crack spacing in each step of [`held_together`].
const FINER: f64 = 0.96;

/// Steps of it at most: half as many nodes again. Twice as many would join the tips of the horse's draft, too, whose strikes then take
/// almost as long as on the lattices of `game`.
const STEPS_MAX: usize = 3;

/// The levels at `spacings`; where these tear parts off and the crack spacing `follows` the object, those at the first finer one that does
/// not, which `spacings` then has. If none is found in a few steps, those at the first: the parts are named.
pub(super) fn held_together(
    surface: &Surface,
    spacings: &mut Spacings,
    follows: bool,
    stuffed: &dyn Fn(Spacings) -> Result<Levels, BakeError>,
) -> Result<Levels, BakeError> {
    let levels = stuffed(*spacings)?;
    let nodes: usize = levels.bodies.iter().map(|body| body.crack.nodes.len()).sum();
    let (mut finer, mut nodes) = (*spacings, nodes as f64);
    for _ in 0..STEPS_MAX {
        (finer.crack, nodes) = (FINER * finer.crack, nodes / FINER.powi(3));
        if !follows || torn_off(surface, &levels) == 0 || nodes > CRACK_NODES_MAX as f64 {
            break;
        }
        let next = stuffed(finer)?;
        if torn_off(surface, &next) == 0 {
            *spacings = finer;
            return Ok(next);
        }
    }
    Ok(levels)
}

/// Bodies beyond the input's own parts.
fn torn_off(surface: &Surface, levels: &Levels) -> usize {
    levels.bodies.len().saturating_sub(surface.parts.len().max(1))
}

/// What comes apart, named.
pub(super) fn severed(surface: &Surface, levels: &Levels) -> Option<Defect> {
    let more = Some(torn_off(surface, levels)).filter(|more| *more > 0)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::{BakeRequest, bake};
    use crate::pipeline::Quality;
    use crate::scene::Materials;
    use crate::surface::shapes;
    use crate::token::Token;

    #[test]
    fn a_spacing_that_nobody_asked_for_tears_nothing_off() {
        let materials = Materials::parse(include_str!("../../../../config/materials.toml")).unwrap();
        let material = materials.get("glass").unwrap().clone();
        let request = |crack_spacing| BakeRequest {
            quality: Quality::Draft,
            crack_spacing,
            ..BakeRequest::new("statue", "glass", material.clone())
        };
        let baked = |request| bake(shapes::statue(), &request, &Token::default(), &mut |_| ()).unwrap();
        let own = baked(request(None));
        let torn = |defect: &&Defect| defect.kind == DefectKind::SeveredPart;
        assert_eq!((own.bodies.len(), own.report.defects.iter().find(torn)), (1, None));
        // The last step that was not taken, asked for.
        let coarser = own.parameters.crack_spacing / FINER;
        let asked = baked(request(Some(coarser)));
        assert_eq!(asked.parameters.crack_spacing, coarser);
        println!("{} and {} nodes", own.crack_nodes(), asked.crack_nodes());
        assert!(asked.bodies.len() > 1 && asked.report.defects.iter().any(|defect| torn(&defect)));
    }
}
