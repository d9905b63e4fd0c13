//! Edges of a surface that do not join exactly two triangles of the same orientation, as a count and places.

use nalgebra::Point3;
use std::collections::BTreeMap;
use std::fmt;

/// Maximum number of places that a report lists.
const LISTED_MAX: usize = 5;

/// Kind of an edge that keeps a surface from being closed, the gravest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EdgeDefectKind {
    /// One triangle has the edge.
    Open,
    /// More than two triangles have the edge.
    Branching,
    /// Both triangles run through the edge in the same direction.
    Reversed,
}

/// Edges of one kind, as connected groups: a hole in the mesh is one group.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeDefects {
    /// Kind of the edges.
    pub kind: EdgeDefectKind,
    /// Number of connected groups of edges.
    pub groups: usize,
    /// A vertex of each of the first groups, local.
    pub places: Vec<Point3<f64>>,
}

impl EdgeDefects {
    /// Groups the edges of the gravest kind; `None` if every edge joins two triangles of the same orientation.
    pub(super) fn find(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Option<Self> {
        // Triangles that run through the edge from its lower to its higher vertex, and back.
        let mut uses: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for [a, b] in triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]) {
            uses.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
        let kind_of = |&[there, back]: &[u32; 2]| match (there, back) {
            (1, 1) => None,
            (1, 0) | (0, 1) => Some(EdgeDefectKind::Open),
            (2, 0) | (0, 2) => Some(EdgeDefectKind::Reversed),
            _ => Some(EdgeDefectKind::Branching),
        };
        let kind = uses.values().filter_map(kind_of).min()?;
        let edges = uses.iter().filter(|(_, count)| kind_of(count) == Some(kind)).map(|(edge, _)| *edge);
        let starts = group_starts(edges);
        let places = starts.iter().take(LISTED_MAX).filter_map(|vertex| positions.get(*vertex as usize).copied());
        Some(Self { kind, groups: starts.len(), places: places.collect() })
    }

    /// Describes the defect with its places, which `to_meters` converts.
    pub(super) fn describe(&self, to_meters: impl Fn(&Point3<f64>) -> Point3<f64>) -> String {
        let shown = |place: &Point3<f64>| {
            let at = to_meters(place);
            format!("({:.4}, {:.4}, {:.4})", at.x, at.y, at.z)
        };
        let places: Vec<String> = self.places.iter().map(shown).collect();
        let more = match self.groups - places.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let groups = if self.groups == 1 { "one place".to_owned() } else { format!("{} places", self.groups) };
        format!("{} at {groups}: near {}{more}, in meters", self.kind, places.join(", "))
    }
}

impl fmt::Display for EdgeDefectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Open => "the mesh is open",
            Self::Branching => "more than two triangles of the mesh share an edge",
            Self::Reversed => "triangles of the mesh face different ways",
        })
    }
}

/// The lowest vertex of each connected group of edges, in ascending order.
fn group_starts(edges: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut neighbors: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in edges {
        neighbors.entry(a).or_default().push(b);
        neighbors.entry(b).or_default().push(a);
    }
    let mut starts = Vec::new();
    while let Some((start, first)) = neighbors.pop_first() {
        starts.push(start);
        let mut pending = first;
        while let Some(vertex) = pending.pop() {
            pending.extend(neighbors.remove(&vertex).into_iter().flatten());
        }
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::shapes;

    /// Defects of a cube of side 1 around the origin, whose triangles `change` alters.
    fn defects(change: impl Fn(&mut Vec<[u32; 3]>)) -> Option<EdgeDefects> {
        let mut cube = shapes::cuboid([1.0; 3]);
        change(&mut cube.triangles);
        EdgeDefects::find(&cube.positions_m, &cube.triangles)
    }

    #[test]
    fn holes_are_counted_and_located() {
        assert_eq!(defects(|_| ()), None);
        let hole = defects(|triangles| triangles.truncate(triangles.len() - 1)).unwrap();
        assert_eq!((hole.kind, hole.groups, hole.places.len()), (EdgeDefectKind::Open, 1, 1));
        let text = hole.describe(|place| place * 2.0);
        assert!(text.starts_with("the mesh is open at one place: near (") && text.contains("1.0000"), "{text}");
        let apart = |copies: u32| {
            let cube = shapes::cuboid([1.0; 3]);
            let count = cube.positions_m.len() as u32;
            let positions: Vec<_> = (0..copies).flat_map(|_| cube.positions_m.clone()).collect();
            let moved = |copy: u32| cube.triangles.iter().skip(1).map(move |t| t.map(|v| v + copy * count));
            EdgeDefects::find(&positions, &(0..copies).flat_map(moved).collect::<Vec<_>>()).unwrap()
        };
        assert!(apart(3).describe(|place| *place).starts_with("the mesh is open at 3 places: near ("));
        let many = apart(7);
        assert_eq!((many.groups, many.places.len()), (7, 5));
        assert!(many.describe(|place| *place).contains(" and 2 more"));
    }

    #[test]
    fn kinds_of_edges_are_distinguished() {
        let reversed = defects(|triangles| triangles[0].reverse()).unwrap();
        assert_eq!((reversed.kind, reversed.groups), (EdgeDefectKind::Reversed, 1));
        let doubled = defects(|triangles| triangles.push(triangles[0])).unwrap();
        assert_eq!((doubled.kind, doubled.groups), (EdgeDefectKind::Branching, 1));
        let both = defects(|triangles| {
            triangles[0].reverse();
            triangles.truncate(triangles.len() - 1);
        });
        assert_eq!(both.unwrap().kind, EdgeDefectKind::Open, "an open edge is the gravest");
    }
}
