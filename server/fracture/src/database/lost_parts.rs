//! Parts of an object that a lattice loses, severs, or leaves without elasticity, for the defect report.

use super::bake_error::BakeError;
use super::joints::{JoinRemedy, JoinedShape, Joint, SeveredBody};
use crate::lattice::{CRACK_NODES_MAX, LatticeLevels, Spacings};
use crate::pipeline::Preset;
use crate::surface::{Defect, DefectKind, InsideTest, ShellPart, Solids, Surface};
use nalgebra::Point3;
use rayon::prelude::*;

/// Factor on the crack spacing in each step of [`refine_until_connected`].
const FINER: f64 = 0.96;

/// Largest number of those steps, which give about half as many nodes again.
///
/// Chosen for the horse in `draft`: twice as many steps would also join its tips, but requests would then take almost
/// as long as in `game`.
const STEPS_MAX: usize = 3;

/// The lattices at `spacings`, refined in steps until no part is severed, if the crack spacing `follows` the object.
///
/// `spacings` is set to the spacing found. If a few steps do not suffice, returns the lattices at the original spacing;
/// the report names the parts.
pub(super) fn refine_until_connected(
    surface: &Surface,
    spacings: &mut Spacings,
    follows: bool,
    stuffed: &dyn Fn(Spacings) -> Result<LatticeLevels, BakeError>,
) -> Result<LatticeLevels, BakeError> {
    let levels = stuffed(*spacings)?;
    let nodes: usize = levels.bodies.iter().map(|body| body.crack.nodes.len()).sum();
    let (mut finer, mut nodes) = (*spacings, nodes as f64);
    for _ in 0..STEPS_MAX {
        (finer.crack, nodes) = (FINER * finer.crack, nodes / FINER.powi(3));
        if !follows || severed_bodies(surface, &levels).is_empty() || nodes > CRACK_NODES_MAX as f64 {
            break;
        }
        let next = stuffed(finer)?;
        if severed_bodies(surface, &next).is_empty() {
            *spacings = finer;
            return Ok(next);
        }
    }
    Ok(levels)
}

/// Smallest number of a body's nodes in a solid, and their smallest share, for the body to be part of it: nodes near a gap may lie
/// in the solid on its other side.
const HELD_MIN: (usize, f64) = (4, 0.01);

/// Bodies beyond the input's own solids: of each solid, all bodies but the largest. Largest first.
fn severed_bodies(surface: &Surface, levels: &LatticeLevels) -> Vec<SeveredBody> {
    let mut severed: Vec<SeveredBody> = Vec::new();
    for bodies in bodies_of_solids(surface, levels) {
        // Bodies are in the order of their volumes.
        let others = |body| bodies.iter().copied().filter(|other| *other != body).collect();
        severed.extend(bodies.iter().skip(1).map(|&body| SeveredBody { body, others: others(body) }));
    }
    severed.sort_by_key(|own| own.body);
    severed.dedup_by_key(|own| own.body);
    severed.truncate(levels.bodies.len().saturating_sub(1));
    severed
}

/// For each solid of the input, the bodies in it.
fn bodies_of_solids(surface: &Surface, levels: &LatticeLevels) -> Vec<Vec<usize>> {
    if levels.bodies.len() < 2 || surface.solid_count < 2 {
        return vec![(0..levels.bodies.len()).collect()];
    }
    let solids = Solids::of(surface);
    let mut parts = vec![Vec::new(); surface.solid_count];
    for (index, body) in levels.bodies.iter().enumerate() {
        let nodes = &body.crack.nodes;
        let holding: Vec<usize> = nodes.par_iter().filter_map(|node| solids.holding(node)).collect();
        let mut held = vec![0_usize; parts.len()];
        holding.iter().for_each(|&solid| held[solid] += 1);
        let most = held.iter().copied().max().unwrap_or(0);
        let enough = most.min(HELD_MIN.0.max((HELD_MIN.1 * nodes.len() as f64) as usize)).max(1);
        parts.iter_mut().zip(&held).filter(|(_, held)| **held >= enough).for_each(|(part, _)| part.push(index));
    }
    parts
}

/// Parts that the lattice severs from the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct SeveredParts {
    /// Number of bodies of the lattice.
    pub bodies: usize,
    /// Number of solids of the input.
    pub solids: usize,
    /// Volumes of the severed bodies, m³, in descending order.
    pub volumes_m3: Vec<f64>,
    /// Preset that severs them; `None` if the spacing was given.
    pub quality: Option<Preset>,
    /// Thinnest joint that the lattice lost, if one was found.
    pub joint: Option<Joint>,
    /// The remedy that holds the parts together.
    pub remedy: JoinRemedy,
    face: u64,
}

/// The severed parts of a shape of `volume` (local), if any. `keeps` returns true if another preset does not sever them.
pub(super) fn severed(
    surface: &Surface,
    inside: &InsideTest,
    (levels, volume): (&LatticeLevels, f64),
    quality: Option<Preset>,
    keeps: &dyn Fn(Preset) -> Result<bool, BakeError>,
) -> Result<Option<SeveredParts>, BakeError> {
    let severed = severed_bodies(surface, levels);
    let Some(first) = severed.first() else { return Ok(None) };
    let cubed = surface.frame.diagonal_m.powi(3);
    let joint = Joint::find(surface, inside, levels, &severed);
    let shape = JoinedShape { surface, inside, volume, area: area(surface) };
    let face = || inside.nearest_face(&levels.bodies[first.body].crack.nodes[0]);
    Ok(Some(SeveredParts {
        bodies: levels.bodies.len(),
        solids: surface.solid_count.max(1),
        volumes_m3: severed.iter().map(|own| levels.bodies[own.body].crack.volume() * cubed).collect(),
        quality,
        remedy: shape.remedy(joint.as_ref(), quality, keeps)?,
        face: joint.map_or_else(face, |joint| joint.face),
        joint,
    }))
}

/// True if a preset's own spacings do not sever any part.
pub(super) fn keeps(
    surface: &Surface,
    spacings: Spacings,
    stuffed: &dyn Fn(Spacings) -> Result<LatticeLevels, BakeError>,
) -> Result<bool, BakeError> {
    let mut spacings = spacings;
    Ok(severed_bodies(surface, &refine_until_connected(surface, &mut spacings, true, stuffed)?).is_empty())
}

impl SeveredParts {
    /// Entry of the defect report.
    pub(super) fn defect(&self) -> Defect {
        let action = format!(
            "separate bodies, {}: their connection{} is too thin for the lattice; {}",
            self.sizes(),
            self.joint(),
            self.advice()
        );
        Defect::new(DefectKind::SeveredPart, self.volumes_m3.len() as u64, self.face, action)
    }

    fn sizes(&self) -> String {
        match self.volumes_m3.as_slice() {
            [one] => format!("{one:.3e} m³"),
            [largest, .., least] => format!("{least:.3e} to {largest:.3e} m³"),
            [] => String::new(),
        }
    }

    fn advice(&self) -> String {
        self.remedy.advice(self.joint.as_ref())
    }

    /// The joint in words, empty if it is unknown.
    fn joint(&self) -> String {
        self.joint.as_ref().map_or_else(String::new, Joint::words)
    }
}

impl std::fmt::Display for SeveredParts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = self.quality.unwrap_or_default().name();
        let (parts, sizes, joint, advice) = (self.defect().counted(), self.sizes(), self.joint(), self.advice());
        write!(
            f,
            "preset `{name}` severs {parts} of {sizes} from the object, whose joint{joint} is too thin: {advice}; an explicit \
             --quality {name} "
        )?;
        write!(f, "makes {} bodies where the mesh has {}", self.bodies, self.solids)
    }
}

/// Crack nodes far from any elastic lattice.
pub(super) fn far(inside: &InsideTest, levels: &LatticeLevels) -> Option<Defect> {
    let first = inside.nearest_face(levels.far.first()?);
    let action =
        "energy taken from the nearest part: limbs thinner than the elastic spacing; try a finer --elastic-spacing";
    Some(Defect::new(DefectKind::CoarseElastic, levels.far.len() as u64, first, action))
}

/// Beginning of what the report says of them.
pub(super) const LEFT_OUT: &str = "left out: smaller than the lattice spacing";

/// Components that the crack lattice lost: those that it dropped, and shells without a node in their bounding box.
pub(super) struct LostComponents {
    /// Number of components.
    pub count: u64,
    /// Total volume, local.
    pub volume: f64,
    /// A point in the first dropped component, or else a face of the first missing shell.
    first: Option<First>,
}

enum First {
    Place(Point3<f64>),
    Face(u64),
}

/// The components that the crack lattice lost, of a shape of `volume` (local).
///
/// If the lattice swells to match the volume, dropped components have swollen as well. Therefore their share counts,
/// not their size.
pub(super) fn dropped_components(surface: &Surface, levels: &LatticeLevels, volume: f64) -> LostComponents {
    let nodes = || levels.bodies.iter().flat_map(|body| &body.crack.nodes);
    let holds = |part: &ShellPart, node: &Point3<f64>| (0..3).all(|k| (part.low[k]..=part.high[k]).contains(&node[k]));
    let dropped = &levels.crack.dropped;
    let missed: Vec<&ShellPart> = surface
        .parts
        .iter()
        .filter(|part| !nodes().any(|node| holds(part, node)))
        .filter(|part| !dropped.iter().any(|dropped| holds(part, &dropped.place)))
        .collect();
    let dropped_volume: f64 = dropped.iter().map(|component| component.volume).sum();
    let missed_volume: f64 = missed.iter().map(|part| part.volume).sum();
    let dropped_share = dropped_volume / (dropped_volume + levels.crack.volume);
    let place = dropped.first().map(|dropped| First::Place(dropped.place));
    LostComponents {
        count: (dropped.len() + missed.len()) as u64,
        volume: missed_volume + dropped_share * (volume - missed_volume).max(0.0),
        first: place.or(missed.first().map(|part| First::Face(part.face))),
    }
}

impl LostComponents {
    /// Entry of the defect report, with the share of the input's volume.
    pub fn defect(&self, inside: &InsideTest, surface: &Surface, volume: f64) -> Option<Defect> {
        let first = match self.first.as_ref()? {
            First::Place(place) => inside.nearest_face(place),
            First::Face(face) => *face,
        };
        let (share, lost_m3) = (100.0 * self.volume / volume, self.volume * surface.frame.diagonal_m.powi(3));
        let action = format!("{LEFT_OUT}, {lost_m3:.3e} m³, {share:.4} % of the volume");
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
    use crate::cancel_token::CancelToken;
    use crate::database::{BakeRequest, Tables, bake};
    use crate::pipeline::{Preset, SurfaceKind};
    use crate::scene::Materials;
    use crate::surface::{RawMesh, shapes};

    #[test]
    fn a_default_spacing_severs_no_part() {
        let materials = Materials::parse(crate::scene::MATERIALS).unwrap();
        let material = materials.get("glass").unwrap().clone();
        let request = |crack_spacing| BakeRequest {
            quality: Preset::Draft,
            crack_spacing,
            tables: Tables::NONE,
            ..BakeRequest::new("statue", "glass", material.clone())
        };
        let baked = |request| bake(shapes::statue(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
        let own = baked(request(None));
        let torn = |defect: &&Defect| defect.kind == DefectKind::SeveredPart;
        assert_eq!((own.bodies.len(), own.report.defects.iter().find(torn)), (1, None));
        // The last rejected step of the refinement, as a given spacing.
        let coarser = own.parameters.crack_spacing / FINER;
        let asked = baked(request(Some(coarser)));
        assert_eq!(asked.parameters.crack_spacing, coarser);
        println!("{} and {} nodes", own.crack_nodes(), asked.crack_nodes());
        assert!(asked.bodies.len() > 1 && asked.report.defects.iter().any(|defect| torn(&defect)));
    }

    #[test]
    fn a_severing_preset_is_rejected_unless_it_is_explicit() {
        let materials = Materials::parse(crate::scene::MATERIALS).unwrap();
        let tables = Tables { interior: true, ..Tables::NONE };
        let request = BakeRequest {
            quality: Preset::Draft,
            allows_severed: false,
            surface: SurfaceKind::Lattice,
            tables,
            ..BakeRequest::new("dumbbell", "glass", materials.get("glass").unwrap().clone())
        };
        // Two blocks and a rod between them that the lattice of `draft` does not resolve.
        let baked = |mesh, request: &BakeRequest| bake(mesh, request, &CancelToken::default(), &mut |_| ());
        let dust = || joined(&[limbs(), block([5.0; 3], [5.02; 3])]);
        let meshes = [limbs(), overlapping_limbs(0.01), divided_rod(1.5, true), divided_rod(1.6, false), dust()];
        for (mesh, solids) in meshes.into_iter().zip([1, 1, 1, 1, 2]) {
            let Err(BakeError::Severed(severed)) = baked(mesh, &request) else { panic!("it was baked") };
            let message = severed.to_string();
            println!("{message}");
            assert_eq!((severed.solids, severed.bodies, severed.volumes_m3.len()), (solids, 2, 1), "{message}");
            // The rod is thinner than all presets and spacings hold.
            assert!(matches!(severed.remedy, JoinRemedy::Thickness(needed_m) if needed_m > 2.0 * ROD), "{message}");
            assert!(message.contains("`draft`") && message.contains("thicken it to"), "{message}");
            let joint = severed.joint.unwrap();
            assert!((joint.thickness_m / (2.0 * ROD) - 1.0).abs() < 1e-2, "{joint:?}");
            assert!((1.0..=2.0).contains(&joint.place_m.x) && joint.place_m.coords.yz().norm() < ROD, "{joint:?}");
        }
        let box_to = |high: f64| block([0.0; 3], [high; 3]);
        let inward = |mut mesh: RawMesh| {
            mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh
        };
        let cavity = inward(block([0.2; 3], [0.8; 3]));
        // Apart, touching along an edge or a part of it, and one in a cavity of the other.
        for (first, more) in [
            (box_to(1.0), vec![block([1.5, 0.0, 0.0], [2.25, 0.75, 0.75])]),
            (box_to(1.0), vec![block([1.0, 0.0, 1.0], [1.75, 0.75, 1.75])]),
            (box_to(1.0), vec![block([1.0, 0.5, 1.0], [2.0, 1.5, 2.0])]),
            (box_to(1.0), vec![cavity, block([0.35; 3], [0.65; 3])]),
            (shapes::sphere(0.8, 3), vec![inward(shapes::sphere(0.6, 3)), shapes::sphere(0.35, 2)]),
        ] {
            let mesh = joined(&[vec![first], more].concat());
            assert_eq!(Surface::repair(mesh.clone()).unwrap().solid_count, 2);
            assert_eq!(baked(mesh, &request).unwrap().bodies.len(), 2);
        }
        let allowed = baked(limbs(), &BakeRequest { allows_severed: true, ..request.clone() }).unwrap();
        assert!(allowed.bodies.len() > 1);
        let line = allowed.report.defects.iter().find(|defect| defect.kind == DefectKind::SeveredPart).unwrap();
        assert!(
            line.counted().contains("part") && line.action.contains("m³") && line.action.contains("thicken it to"),
            "{line:?}"
        );
    }

    #[test]
    fn the_volume_is_that_of_the_severed_part_and_the_preset_named_holds_it() {
        let materials = Materials::parse(crate::scene::MATERIALS).unwrap();
        let request = BakeRequest {
            allows_severed: false,
            surface: SurfaceKind::Lattice,
            tables: Tables::NONE,
            ..BakeRequest::new("mixed", "glass", materials.get("glass").unwrap().clone())
        };
        let severed = |mesh| match bake(mesh, &request, &CancelToken::default(), &mut |_| ()) {
            Err(BakeError::Severed(severed)) => severed,
            other => panic!("{:?}", other.map(|own| own.bodies.len())),
        };
        // A block of 0.1 m³ apart from the limbs is no severed part.
        let mixed = severed(joined(&[limbs(), block([1.3, 1.0, 0.0], [1.7, 1.5, 0.5])]));
        println!("{mixed}");
        assert_eq!((mixed.bodies, mixed.solids, mixed.volumes_m3.len()), (3, 2, 1));
        assert!(
            (mixed.volumes_m3[0] - 1.0).abs() < 0.05 && mixed.defect().first_index == mixed.joint.unwrap().face,
            "{mixed}"
        );
        let thicker = severed(turned(limbs_by(2.0 * ROD)));
        println!("{thicker}");
        assert_eq!(thicker.remedy, JoinRemedy::Preset(Preset::Film));
        assert!(thicker.to_string().contains("--quality film keeps them"), "{thicker}");
        let between = severed(turned(limbs_by(1.4 * ROD)));
        println!("{between}");
        let JoinRemedy::Spacing(crack) = between.remedy else { panic!("{between}") };
        let request = BakeRequest { crack_spacing: Some(crack), ..request };
        let held = bake(turned(limbs_by(1.4 * ROD)), &request, &CancelToken::default(), &mut |_| ()).unwrap();
        assert_eq!(held.bodies.len(), 1);
    }

    fn turned(mut mesh: RawMesh) -> RawMesh {
        let rotation = nalgebra::Rotation3::from_euler_angles(0.4, 0.3, 0.2);
        mesh.positions_m.iter_mut().for_each(|point| *point = rotation * *point);
        mesh
    }

    /// Two blocks of 1 m, joined by a rod that is too thin for coarse lattices, in one shell.
    fn limbs() -> RawMesh {
        limbs_by(ROD)
    }

    /// The same with a rod of this half thickness, m.
    fn limbs_by(rod: f64) -> RawMesh {
        let rings = [(0.0, 0.5), (1.0, 0.5), (1.0, rod), (2.0, rod), (2.0, 0.5), (3.0, 0.5)];
        let corners = |(x, half): (f64, f64)| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[y, z]| nalgebra::Point3::new(x, y * half, z * half))
        };
        let side =
            |k: u32| [0, 1, 2, 3].map(|c| [4 * k + c, 4 * k + (c + 1) % 4, 4 * k + 4 + (c + 1) % 4, 4 * k + 4 + c]);
        let quads = (0..5).flat_map(side).chain([[3, 2, 1, 0], [20, 21, 22, 23]]);
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        RawMesh::new(rings.into_iter().flat_map(corners).collect(), quads.flat_map(halves).collect())
    }

    /// The same in three shells: the rod reaches into the blocks by `depth` m, or touches them.
    fn overlapping_limbs(depth: f64) -> RawMesh {
        let blocks = [0.0, 2.0].map(|x| block([x, -0.5, -0.5], [x + 1.0, 0.5, 0.5]));
        joined(&[blocks[0].clone(), block([1.0 - depth, -ROD, -ROD], [2.0 + depth, ROD, ROD]), blocks[1].clone()])
    }

    /// The same with a rod of two equal shells: the first begins in the first block, the second at 1.5 m, and the first ends at `end` m.
    /// Shells that end and begin at one place share the vertices there, and the triangles unless the first has `other_diagonals`.
    fn divided_rod(end: f64, other_diagonals: bool) -> RawMesh {
        let blocks = [0.0, 2.0].map(|x| block([x, -0.5, -0.5], [x + 1.0, 0.5, 0.5]));
        let mut rods = [(0.99, end), (1.5, 2.01)].map(|(from, to)| block([from, -ROD, -ROD], [to, ROD, ROD]));
        if other_diagonals {
            for side in rods[0].triangles.chunks_exact_mut(2) {
                let [[a, b, c], [_, _, d]] = [side[0], side[1]];
                side.copy_from_slice(&[[a, b, d], [b, c, d]]);
            }
        }
        joined(&[blocks, rods].concat())
    }

    fn block(low: [f64; 3], high: [f64; 3]) -> RawMesh {
        let mut mesh = shapes::cuboid([0, 1, 2].map(|axis| high[axis] - low[axis]));
        let corner =
            |point: &nalgebra::Point3<f64>, axis: usize| if point[axis] < 0.0 { low[axis] } else { high[axis] };
        mesh.positions_m.iter_mut().for_each(|point| *point = [0, 1, 2].map(|axis| corner(point, axis)).into());
        mesh
    }

    fn joined(parts: &[RawMesh]) -> RawMesh {
        let mut all = RawMesh::new(Vec::new(), Vec::new());
        for part in parts {
            let first = all.positions_m.len() as u32;
            all.positions_m.extend(&part.positions_m);
            all.triangles.extend(part.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
        }
        all
    }

    /// Half the thickness of the rod, m.
    const ROD: f64 = 0.015;
}
