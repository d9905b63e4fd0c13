//! Thin connections at which a lattice severs parts of a solid, and the remedies that hold them together.

use super::wall_limits::{HALF_SPACING_COST, WALL_SPACINGS, WIDTH_MAX};
use crate::lattice::{self, LatticeLevels, Locator};
use crate::pipeline::Preset;
use crate::surface::{InsideTest, Surface, Width};
use nalgebra::Point3;
use rayon::prelude::*;

/// Samples of a joint may be this much farther from the bodies that it joins than the nearest one.
const DETOUR: f64 = 1.1;

/// Body beyond the input's own solids.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SeveredBody {
    /// Index of the body.
    pub body: usize,
    /// The other bodies of its solid.
    pub others: Vec<usize>,
}

/// Thinnest connection between a severed body and the rest of its solid, which the lattice lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Position, m.
    pub place_m: Point3<f64>,
    /// Thickness, m.
    pub thickness_m: f64,
    /// A face of the input at the joint.
    pub face: u64,
    /// Thickness, local.
    pub(super) thickness: f64,
}

impl Joint {
    /// The thinnest joint of the `severed` bodies; `None` if no triangle has its center on one.
    pub(super) fn find(
        surface: &Surface,
        inside: &InsideTest,
        levels: &LatticeLevels,
        severed: &[SeveredBody],
    ) -> Option<Self> {
        let locators: Vec<Locator> = levels.bodies.iter().map(|body| Locator::new(&body.crack)).collect();
        let near = 0.5 * levels.crack.spacing;
        let is_lost = |point: &Point3<f64>| {
            locators.iter().all(|locator| {
                let distance = locator.nearest(point).map_or(f64::INFINITY, |nearest| nearest.distance);
                distance > near && locator.containing(point, None).is_none()
            })
        };
        let lost = inside.walls_at_centers(WIDTH_MAX, is_lost);
        let joints = severed.iter().filter_map(|own| thinnest(&lost, &locators, own));
        let joint = joints.min_by(|one, other| one.width.total_cmp(&other.width))?;
        Some(Self {
            place_m: surface.frame.to_meters(&joint.middle),
            thickness_m: joint.width * surface.frame.diagonal_m,
            face: joint.face,
            thickness: joint.width,
        })
    }
}

/// The thinnest sample among those on the shortest way from a severed body to the others of its solid.
fn thinnest(lost: &[Width], locators: &[Locator], severed: &SeveredBody) -> Option<Width> {
    let distance = |body: usize, point: &Point3<f64>| {
        locators[body].nearest(point).map_or(f64::INFINITY, |nearest| nearest.distance)
    };
    let way = |sample: &Width| {
        let rest = severed.others.iter().map(|&other| distance(other, &sample.middle)).fold(f64::INFINITY, f64::min);
        distance(severed.body, &sample.middle) + rest
    };
    let ways: Vec<f64> = lost.par_iter().map(way).collect();
    let shortest = ways.iter().copied().fold(f64::INFINITY, f64::min);
    let on_the_way = lost.iter().zip(&ways).filter(|(_, way)| **way <= DETOUR * shortest).map(|(sample, _)| *sample);
    on_the_way.min_by(|one, other| one.width.total_cmp(&other.width))
}

/// Remedy that holds severed parts together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JoinRemedy {
    /// A preset whose lattice was tried, or is fine enough.
    Preset(Preset),
    /// A preset that was not tried, because the thickness of the joint is unknown.
    Untried {
        /// The preset.
        preset: Preset,
        /// Finest preset that was tried and severs the parts, too.
        tried: Option<Preset>,
    },
    /// A crack spacing, over the diagonal.
    Spacing(f64),
    /// A finer crack spacing or a thicker joint, of unknown measure.
    Finer,
    /// No lattice of this object holds the joint unless it has this thickness, m.
    Thickness(f64),
}

/// Shape whose joint must be held.
pub(super) struct JoinedShape<'a> {
    /// Surface.
    pub surface: &'a Surface,
    /// Inside test of that surface.
    pub inside: &'a InsideTest,
    /// Volume, local.
    pub volume: f64,
    /// Area, local.
    pub area: f64,
}

impl JoinedShape<'_> {
    /// The remedy for `joint`, which the lattice of preset `quality` severed; `keeps` tries another preset.
    pub(super) fn remedy<E>(
        &self,
        joint: Option<&Joint>,
        quality: Option<Preset>,
        keeps: &dyn Fn(Preset) -> Result<bool, E>,
    ) -> Result<JoinRemedy, E> {
        let finer = std::iter::successors(quality.and_then(Preset::finer), |preset| preset.finer());
        let mut tried = None;
        for preset in finer {
            match (preset.lattices().fitted, joint) {
                // Fitted lattices have ten times as many nodes, so a trial would take longer than this bake.
                (true, None) => return Ok(JoinRemedy::Untried { preset, tried }),
                (true, Some(joint)) if joint.thickness >= WALL_SPACINGS[0] * self.spacing(preset) => {
                    return Ok(JoinRemedy::Preset(preset));
                }
                (true, Some(_)) => {}
                (false, _) => {
                    if keeps(preset)? {
                        return Ok(JoinRemedy::Preset(preset));
                    }
                    tried = Some(preset);
                }
            }
        }
        let Some(joint) = joint else { return Ok(JoinRemedy::Finer) };
        // Rounded to the digits that are printed, so that the advice still holds.
        let printed = (1e4 * joint.thickness / WALL_SPACINGS[0]).floor() / 1e4;
        let finest = (1e4 * self.finest()).ceil() / 1e4;
        if printed >= finest {
            return Ok(JoinRemedy::Spacing(printed));
        }
        Ok(JoinRemedy::Thickness(WALL_SPACINGS[0] * finest * self.surface.frame.diagonal_m))
    }

    fn spacing(&self, preset: Preset) -> f64 {
        lattice::default_spacing(self.volume, self.area, preset.lattices().crack_nodes)
    }

    fn finest(&self) -> f64 {
        let by_nodes = lattice::default_spacing(self.volume, self.area, lattice::CRACK_NODES_MAX);
        by_nodes.max(self.inside.finest_grid_spacing(0.0))
    }
}

impl JoinRemedy {
    /// The advice for `joint`.
    pub(super) fn advice(&self, joint: Option<&Joint>) -> String {
        let divide = "or bake the parts as separate objects";
        match (self, joint) {
            (Self::Preset(preset), _) => format!("--quality {} keeps them", preset.name()),
            (Self::Untried { preset, tried }, _) => {
                let tried =
                    tried.map_or_else(String::new, |tried| format!("--quality {} severs them, too; ", tried.name()));
                format!("{tried}try --quality {}, whose lattices may have ten times as many nodes", preset.name())
            }
            (Self::Spacing(spacing), _) => {
                format!(
                    "no preset is sure to hold them; --crack-spacing {spacing:.4} is, and coarser ones may be; {HALF_SPACING_COST}"
                )
            }
            (Self::Thickness(thickness_m), Some(joint)) => format!(
                "no preset and no --crack-spacing is sure to hold a joint of {:.3e} m: try finer ones, thicken it to {:.3e} \
                 m, {divide}",
                joint.thickness_m,
                // Rounded up.
                1.0005 * thickness_m
            ),
            (Self::Finer | Self::Thickness(_), _) => {
                format!("give a finer --crack-spacing ({HALF_SPACING_COST}), thicken the joint, {divide}")
            }
        }
    }
}

impl Joint {
    /// The position and thickness, in words.
    pub(super) fn words(&self) -> String {
        format!(" ({:.3e} m thick near {})", self.thickness_m, place(&self.place_m))
    }
}

/// Position in meters.
pub(super) fn place(point: &Point3<f64>) -> String {
    // Adding 0 turns −0 into 0.
    let [x, y, z] = [point.x, point.y, point.z].map(|own| format!("{:.4}", (1e4 * own).round() / 1e4 + 0.0));
    format!("({x}, {y}, {z}) m")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::shapes;

    #[test]
    fn a_preset_that_severs_too_is_told_before_one_that_was_not_tried() {
        let surface = Surface::repair(shapes::cuboid([1.0; 3])).unwrap();
        let inside = InsideTest::new(&surface);
        let shape = JoinedShape { surface: &surface, inside: &inside, volume: 0.2, area: 2.0 };
        let remedy = |quality, keeps: bool| shape.remedy(None, Some(quality), &|_| Ok::<_, ()>(keeps)).unwrap();
        assert_eq!(remedy(Preset::Draft, true), JoinRemedy::Preset(Preset::Game));
        let advice = |quality| remedy(quality, false).advice(None);
        let film = "try --quality film, whose lattices may have ten times as many nodes";
        assert_eq!(advice(Preset::Draft), format!("--quality game severs them, too; {film}"));
        assert_eq!(advice(Preset::Game), film);
    }
}
