//! Repair of triangle meshes: an oriented surface with an inside, and a list of defects.

mod clean;
mod disjoint_sets;
mod edges;
mod given_windings;
mod intersect;
mod inverted_parts;
mod meeting;
mod orient;
mod radial;
mod shared_space;
mod shells;
use clean::Duplicates;
pub(super) use clean::is_flat;
pub(crate) use disjoint_sets::DisjointSets;
pub(crate) use intersect::{crossings, meet};
pub(crate) use meeting::meeting_point;
pub use shells::ShellPart;

#[cfg(test)]
mod tests;

use super::defect::DefectTally;
use super::shape::Outliers;
use super::{Defect, DefectKind, LocalFrame, RawMesh, SurfaceError, TriangleAttributes};
use edges::{Edges, HalfEdge};
use given_windings::given_windings;
use nalgebra::Point3;
use shells::Shells;

/// Welded, consistently wound, outward-facing surface in local coordinates.
///
/// It may still be open or intersect itself; [`super::InsideTest`] handles both.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Transform between the object's coordinates and local ones.
    pub frame: LocalFrame,
    /// Vertex positions, local. Every vertex is used.
    pub positions: Vec<Point3<f64>>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Face of the input file that each triangle came from, counted from 0.
    pub faces: Vec<u64>,
    /// Attributes of the triangles. Normals are those of the file even where triangles were flipped.
    pub attributes: TriangleAttributes,
    /// Outermost shells that enclose a volume.
    pub parts: Vec<ShellPart>,
    /// Solid of each triangle, counted from 0. Shells that overlap or touch along a face are one solid, with their cavities.
    pub solids: Vec<u32>,
    /// Number of solids.
    pub solid_count: usize,
    /// Vertices far from all others, if there are at most a few.
    pub(super) outliers: Option<Outliers>,
    /// Triangles that were dropped because others have the same corners.
    pub(crate) duplicates: Duplicates,
    /// Defects of the input, sorted by kind.
    pub defects: Vec<Defect>,
    /// True if every edge is passed equally often in both directions, so that the winding number is an integer.
    pub closed: bool,
    /// True if the winding number is 0 or 1 everywhere, so that [`Surface::signed_volume`] is the volume.
    ///
    /// That holds if the surface is closed, does not intersect itself and is nested accordingly.
    pub simple: bool,
}

impl Surface {
    /// Repairs a mesh and lists all its defects.
    ///
    /// Welds bitwise-equal positions, drops duplicate triangles and those without area, makes the winding consistent,
    /// and turns inverted shells outward, unless the windings are already those of a solid. Cavities are kept.
    ///
    /// # Errors
    /// [`RawMesh::check`]'s, and meshes without extent or area.
    pub fn repair(raw: RawMesh) -> Result<Self, SurfaceError> {
        raw.check()?;
        let mut defects = Vec::new();
        let clean::CleanMesh { frame, positions, mut triangles, source, is_turned, turned_parts, duplicates } =
            clean::clean(&raw, &mut defects)?;
        let face = |triangle: u32| raw.face(source[triangle as usize] as usize);
        let wound = triangles.clone();
        let edges = Edges::new(&triangles);
        let patches = orient::orient(&positions, &mut triangles, &edges, face);
        patches.turned.report(DefectKind::MixedWinding, "turned to agree with their neighbors", &mut defects);
        patches.twisted.report(DefectKind::NonOrientable, "not repaired: the surface is one-sided here", &mut defects);
        let given = given_windings(&positions, &triangles, &patches.members);
        let members = match given {
            Some(_) => radial::join_patches(&positions, &triangles, &Edges::new(&triangles), patches.members),
            None => patches.members,
        };
        let mut shells = shells::face_outward(&positions, &mut triangles, &members, given, face);
        shells.flipped.merge(&turned_parts);
        report_shells(&shells, &mut defects);
        if let [_, second, ..] = &members[..] {
            let count = members.len() as u64;
            defects.push(Defect::new(DefectKind::SeveralShells, count, face(second[0]), "merged into one object"));
        }
        let edges = Edges::new(&triangles);
        report_edges(&edges, &triangles, positions.len(), face, &mut defects);
        let shell_of = shell_of(&members, triangles.len());
        let crossings = intersect::intersections(&positions, &triangles, &shell_of);
        let sharing: Vec<[u32; 2]> = crossings.joined.iter().copied().chain(divided(&edges, &shell_of)).collect();
        let (solid_of_shell, solid_count) = shells.solids(members.len(), &sharing);
        let solids = shell_of.iter().map(|&shell| solid_of_shell[shell as usize]).collect();
        if let Some(first) = crossings.first {
            let action = match crossings.complete {
                true => "the inside of both parts counts",
                false => "the inside of both parts counts; counting stopped early",
            };
            defects.push(Defect::new(DefectKind::SelfIntersection, crossings.count, face(first), action));
        }
        let closed = edges.balanced();
        let simple = closed && crossings.complete && crossings.count == 0 && shells.simple;
        let faces = (0..triangles.len() as u32).map(face).collect();
        let changed = wound.iter().zip(&triangles).map(|(before, after)| before != after);
        let turned: Vec<bool> = changed.zip(is_turned).map(|(changed, earlier)| changed != earlier).collect();
        for (what, triangle) in &raw.attributes.lost {
            let action = format!("{what} left out: not every triangle has them{}", TriangleAttributes::range(what));
            defects.push(Defect::new(DefectKind::LostAttributes, 1, raw.face(*triangle as usize), action));
        }
        defects.sort_by_key(|defect| defect.kind);
        let attributes = raw.attributes.clone().fitting(raw.triangles.len()).of(&source, &turned);
        let (parts, outliers) = (shells.parts, Outliers::of(&raw));
        Ok(Self {
            frame,
            positions,
            triangles,
            faces,
            attributes,
            parts,
            solids,
            solid_count,
            outliers,
            duplicates,
            defects,
            closed,
            simple,
        })
    }

    /// True if every edge is passed equally often in both directions.
    pub(crate) fn is_balanced(&self) -> bool {
        Edges::new(&self.triangles).balanced()
    }

    /// The three corners of a triangle, local.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Area of the first `count` triangles, local.
    pub(crate) fn area(&self, count: usize) -> f64 {
        self.triangles[..count].iter().map(|corners| orient::area_vector(&self.positions, corners).norm()).sum()
    }

    /// Integral of the winding number over space, by the divergence theorem; local. The
    /// volume if the surface is closed.
    pub fn signed_volume(&self) -> f64 {
        let cone = |t| {
            let [a, b, c] = self.corners(t).map(|corner| corner.coords);
            a.dot(&b.cross(&c)) / 6.0
        };
        (0..self.triangles.len()).map(cone).sum()
    }
}

/// Pairs of shells that bound a solid together: each is open along an edge that both have.
fn divided<'a>(edges: &'a Edges, shell_of: &'a [u32]) -> impl Iterator<Item = [u32; 2]> + 'a {
    edges.groups().filter(|group| group.len() > 2).flat_map(|group| {
        let shell = |half: &HalfEdge| shell_of[half.triangle as usize];
        let is_open = |of: u32| group.iter().filter(|half| shell(half) == of).count() % 2 == 1;
        let open: Vec<u32> = group.iter().map(shell).filter(|&shell| is_open(shell)).collect();
        open.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
    })
}

/// Shell of each triangle.
fn shell_of(members: &[Vec<u32>], triangle_count: usize) -> Vec<u32> {
    let mut shell_of = vec![0; triangle_count];
    for (shell, members) in members.iter().enumerate() {
        members.iter().for_each(|&triangle| shell_of[triangle as usize] = shell as u32);
    }
    shell_of
}

fn report_shells(shells: &Shells, defects: &mut Vec<Defect>) {
    shells.flipped.report(DefectKind::FlippedShell, "turned outward", defects);
    let (mut nested, cavities, solids) = (DefectTally::default(), shells.cavities.count(), shells.solids.count());
    nested.merge(&shells.cavities);
    nested.merge(&shells.solids);
    let action = match (cavities, solids) {
        (1, 0) => "kept as a cavity".to_owned(),
        (_, 0) => "kept as cavities".to_owned(),
        (0, _) => "kept as solid".to_owned(),
        (1, _) => format!("1 kept as a cavity, {solids} as solid"),
        _ => format!("{cavities} kept as cavities, {solids} as solid"),
    };
    nested.report(DefectKind::NestedShells, action, defects);
}

/// Reports holes, edges of more than two triangles, and bow ties.
fn report_edges(
    edges: &Edges,
    triangles: &[[u32; 3]],
    vertices: usize,
    face: impl Fn(u32) -> u64,
    defects: &mut Vec<Defect>,
) {
    let mut non_manifold = DefectTally::default();
    let mut fans = DisjointSets::new(triangles.len() * 3);
    let mut rims: Vec<&HalfEdge> = Vec::new();
    let mut loops = DisjointSets::new(vertices);
    for group in edges.groups() {
        for pair in group.windows(2) {
            join_fans(&mut fans, &pair[0], &pair[1]);
        }
        if group.len() > 2 {
            non_manifold.note(face(group[0].triangle));
        } else if let [rim] = group {
            rims.push(rim);
            loops.join(rim.ends[0], rim.ends[1]);
        }
    }
    let mut holes = DefectTally::default();
    let mut seen = vec![false; vertices];
    for rim in rims {
        if !std::mem::replace(&mut seen[loops.root(rim.ends[0]) as usize], true) {
            holes.note(face(rim.triangle));
        }
    }
    holes.report(DefectKind::Holes, "closed where the winding number is one half", defects);
    non_manifold.report(DefectKind::NonManifoldEdge, "kept", defects);
    bow_ties(&mut fans, triangles, vertices, &face).report(DefectKind::NonManifoldVertex, "kept", defects);
}

/// Joins the corners of two triangles at the ends of a shared edge. Corner k of triangle t has index 3 t + k.
fn join_fans(fans: &mut DisjointSets, a: &HalfEdge, b: &HalfEdge) {
    let corner = |half: &HalfEdge, lower: bool| {
        let offset = if half.forward == lower { half.side } else { (half.side + 1) % 3 };
        half.triangle * 3 + u32::from(offset)
    };
    fans.join(corner(a, true), corner(b, true));
    fans.join(corner(a, false), corner(b, false));
}

/// Vertices whose corners form more than one fan, each counted once.
fn bow_ties(
    fans: &mut DisjointSets,
    triangles: &[[u32; 3]],
    vertices: usize,
    face: impl Fn(u32) -> u64,
) -> DefectTally {
    let mut fan_of = vec![u32::MAX; vertices];
    let mut tied = vec![false; vertices];
    let mut tally = DefectTally::default();
    for (corner, &vertex) in triangles.iter().flatten().enumerate() {
        let (fan, vertex) = (fans.root(corner as u32), vertex as usize);
        if fan_of[vertex] == u32::MAX {
            fan_of[vertex] = fan;
        } else if fan_of[vertex] != fan && !std::mem::replace(&mut tied[vertex], true) {
            tally.note(face(corner as u32 / 3));
        }
    }
    tally
}
