//! Outward orientation of patches.
//!
//! Windings that are already those of a solid stay. Else the signed volume decides for a patch that is closed or nearly so.
//! Negative in empty space means inside out, and the patch is turned. Negative inside another patch means a cavity, and it
//! stays. If the outermost patch was inside out, the patches inside it are turned with it. Panels too open to have a volume of
//! their own are judged together.

use super::super::defect::DefectTally;
use super::super::tree::{BoundingBox, TriangleTree};
use super::super::winding::WindingMoments;
use super::disjoint_sets::DisjointSets;
use super::given_windings::GivenWindings;
use super::orient::area_vector;
use nalgebra::{Point3, Vector3};

/// Largest ratio of area vector to area of a nearly closed patch; that of a hemisphere is ½.
const OPEN: f64 = 0.45;

/// Shift of the reference point, over the root of the area, that must not change the sign of a valid volume.
const SHIFT: f64 = 0.1;

/// Distance of a patch's sample from the patch, over the root of its largest triangle's area.
const DEPTH: f64 = 1e-6;

/// Result of orienting the shells.
#[derive(Default)]
pub(super) struct Shells {
    /// Patches that were turned.
    pub flipped: DefectTally,
    /// Patches inside others that stay negative.
    pub cavities: DefectTally,
    /// Patches inside others that are positive.
    pub solids: DefectTally,
    /// Outermost shells that enclose a volume.
    pub parts: Vec<ShellPart>,
    /// Pairs of patches that bound one solid: a cavity and the shell around it, shells within a solid, and open panels.
    pub joined: Vec<[u32; 2]>,
    /// True if the winding number can only be 0 or 1, provided that the patches are closed and do not intersect.
    pub simple: bool,
}

/// Outermost shell that encloses a volume; local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellPart {
    /// Lowest corner of its bounding box.
    pub low: Point3<f64>,
    /// Highest corner of its bounding box.
    pub high: Point3<f64>,
    /// Enclosed volume.
    pub volume: f64,
    /// One of its faces in the input file, counted from 0.
    pub face: u64,
}

impl Shells {
    /// The solid of each of `patch_count` patches, counted from 0, and the number of solids. `sharing` are the patches that share space.
    pub fn solids(&self, patch_count: usize, sharing: &[[u32; 2]]) -> (Vec<u32>, usize) {
        let mut sets = DisjointSets::new(patch_count);
        self.joined.iter().chain(sharing).for_each(|&[a, b]| sets.join(a, b));
        let roots: Vec<u32> = (0..patch_count as u32).map(|patch| sets.root(patch)).collect();
        let mut distinct = roots.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let solid = |root: &u32| distinct.partition_point(|other| other < root) as u32;
        (roots.iter().map(solid).collect(), distinct.len())
    }
}

/// Turns patches outward. `given` says which windings are those of a solid; `face` maps a triangle to its face in the report.
pub(super) fn face_outward(
    positions: &[Point3<f64>],
    triangles: &mut [[u32; 3]],
    patches: &[Vec<u32>],
    given: Option<GivenWindings>,
    face: impl Fn(u32) -> u64,
) -> Shells {
    let measures: Vec<Measure> = patches.iter().map(|members| Measure::of(positions, triangles, members)).collect();
    let mut shells = Shells { simple: true, ..Shells::default() };
    let mut turn = vec![false; patches.len()];
    let panels: Vec<usize> = (0..patches.len()).filter(|&p| !measures[p].is_nearly_closed()).collect();
    if !panels.is_empty() {
        let members: Vec<u32> = panels.iter().flat_map(|&p| patches[p].iter().copied()).collect();
        let measure = Measure::of(positions, triangles, &members);
        let inward = given.map_or(measure.has_sign() && measure.volume < 0.0, |given| given == GivenWindings::Inward);
        panels.iter().for_each(|&panel| turn[panel] = inward);
        shells.simple = false;
        shells.joined.extend(panels.windows(2).map(|pair| [pair[0] as u32, pair[1] as u32]));
    }
    let mut solid: Vec<usize> = (0..patches.len()).filter(|&p| measures[p].is_nearly_closed()).collect();
    solid.sort_by(|&a, &b| measures[b].volume.abs().total_cmp(&measures[a].volume.abs()).then(a.cmp(&b)));
    let mut nest = Nest::new(positions, triangles, patches, &measures, &solid);
    for (rank, &patch) in solid.iter().enumerate() {
        let containers = nest.containers(rank);
        let sign = |p: usize, turn: &[bool]| if (measures[p].volume < 0.0) != turn[p] { -1 } else { 1 };
        turn[patch] = match given {
            Some(given) => given == GivenWindings::Inward,
            None => containers.first().is_some_and(|&outermost| turn[outermost]),
        };
        let surrounding: i32 = containers.iter().map(|&p| sign(p, &turn)).sum();
        if given.is_none() && surrounding <= 0 && sign(patch, &turn) < 0 {
            turn[patch] = !turn[patch];
        }
        let own = sign(patch, &turn);
        shells.simple &= (0..=1).contains(&(surrounding + own));
        if containers.is_empty() {
            let Measure { bounds, volume, .. } = &measures[patch];
            let (low, high, volume) = (bounds.low, bounds.high, volume.abs());
            shells.parts.push(ShellPart { low, high, volume, face: face(patches[patch][0]) });
        } else {
            // A solid in a cavity is one of its own.
            let around = containers.last().filter(|_| own < 0 || surrounding > 0);
            shells.joined.extend(around.map(|&around| [around as u32, patch as u32]));
            let tally = if own < 0 { &mut shells.cavities } else { &mut shells.solids };
            tally.note(face(patches[patch][0]));
        }
    }
    for patch in (0..patches.len()).filter(|&p| turn[p]) {
        patches[patch].iter().for_each(|&triangle| triangles[triangle as usize].swap(1, 2));
        shells.flipped.note(face(patches[patch][0]));
    }
    shells
}

/// Area, area vector and signed volume of a patch; the volume is taken about the center of the area.
struct Measure {
    area: f64,
    vector: Vector3<f64>,
    volume: f64,
    bounds: BoundingBox,
    /// Point just inside the patch, near the center of its largest triangle: also where the patch touches another one.
    sample: Point3<f64>,
}

impl Measure {
    fn of(positions: &[Point3<f64>], triangles: &[[u32; 3]], members: &[u32]) -> Self {
        let corners = |t: u32| triangles[t as usize].map(|vertex| positions[vertex as usize]);
        let center_of = |[a, b, c]: [Point3<f64>; 3]| (a.coords + b.coords + c.coords) / 3.0;
        let (mut area, mut vector, mut weighted) = (0.0, Vector3::zeros(), Vector3::zeros());
        let (mut bounds, mut largest, mut widest) = (BoundingBox::EMPTY, Vector3::zeros(), None);
        for &triangle in members {
            let part = area_vector(positions, &triangles[triangle as usize]);
            let size = part.norm();
            let center = center_of(corners(triangle));
            area += size;
            vector += part;
            weighted += center * size;
            bounds = corners(triangle).iter().fold(bounds, |bounds, corner| bounds.with(corner));
            if widest.is_none() || size > largest.norm() {
                (largest, widest) = (part, Some(center));
            }
        }
        let widest = widest.unwrap_or_default();
        let reference = if area > 0.0 { weighted / area } else { widest };
        let cone = |t: u32| {
            let [a, b, c] = corners(t).map(|corner| corner.coords - reference);
            a.dot(&b.cross(&c)) / 6.0
        };
        let volume: f64 = members.iter().map(|&triangle| cone(triangle)).sum();
        let outward = largest.try_normalize(0.0).unwrap_or_default() * volume.signum();
        let sample = Point3::from(widest - outward * DEPTH * largest.norm().sqrt());
        Self { area, vector, volume, bounds, sample }
    }

    /// Returns true if the volume's sign does not depend on the reference point.
    fn has_sign(&self) -> bool {
        let volume_error = SHIFT * self.vector.norm() * self.area.sqrt() / 3.0 + 1e-12 * self.area.powf(1.5);
        self.volume.abs() > volume_error
    }

    fn is_nearly_closed(&self) -> bool {
        self.vector.norm() <= OPEN * self.area && self.has_sign()
    }
}

/// Containment of patches in one another.
struct Nest<'a> {
    positions: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    patches: &'a [Vec<u32>],
    measures: &'a [Measure],
    /// Nearly closed patches, larger volumes first, and a hierarchy of their boxes.
    solid: &'a [usize],
    boxes: TriangleTree,
    /// Hierarchies of patches, built on first use.
    hulls: Vec<Option<(TriangleTree, WindingMoments)>>,
}

impl<'a> Nest<'a> {
    fn new(
        positions: &'a [Point3<f64>],
        triangles: &'a [[u32; 3]],
        patches: &'a [Vec<u32>],
        measures: &'a [Measure],
        solid: &'a [usize],
    ) -> Self {
        let corners = |&p: &usize| [measures[p].bounds.low, measures[p].bounds.high, measures[p].bounds.low];
        let boxes = TriangleTree::new(&solid.iter().map(corners).collect::<Vec<_>>());
        Self { positions, triangles, patches, measures, solid, boxes, hulls: vec![None; patches.len()] }
    }

    /// Patches that contain the one of rank `rank`, larger volumes first.
    fn containers(&mut self, rank: usize) -> Vec<usize> {
        let own = &self.measures[self.solid[rank]];
        let mut ranks = Vec::new();
        self.boxes
            .overlapping(&BoundingBox::of(&[own.sample]), 0, |place| ranks.push(self.boxes.order[place] as usize));
        ranks.retain(|&other| other < rank && self.measures[self.solid[other]].bounds.contains(&own.bounds));
        ranks.sort_unstable();
        let candidates = ranks.into_iter().map(|other| self.solid[other]);
        candidates.filter(|&patch| self.winding(patch, &own.sample).abs() > 0.5).collect()
    }

    fn winding(&mut self, patch: usize, point: &Point3<f64>) -> f64 {
        let (tree, winding) = self.hulls[patch].get_or_insert_with(|| {
            let corners = |&t: &u32| self.triangles[t as usize].map(|vertex| self.positions[vertex as usize]);
            let tree = TriangleTree::new(&self.patches[patch].iter().map(corners).collect::<Vec<_>>());
            let winding = WindingMoments::new(&tree, false);
            (tree, winding)
        });
        let [winding] = winding.at(tree, &[*point]);
        winding
    }
}
