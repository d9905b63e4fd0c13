//! Bounding-box hierarchy over triangles, shared by winding number, closest point and self-intersections.
//!
//! The median of the triangle centers along the longest axis of their box splits each node. The tree is balanced: its
//! depth is at most 32, so a traversal needs only a fixed stack.

use nalgebra::{Point3, Vector3};

/// Largest number of triangles per leaf.
const LEAF: usize = 4;

/// Stack size of a depth-first traversal that pushes both children; depth + 1 suffices.
pub(super) const STACK: usize = 40;

/// Axis-aligned bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoundingBox {
    /// Lowest corner.
    pub low: Point3<f64>,
    /// Highest corner.
    pub high: Point3<f64>,
}

impl BoundingBox {
    /// Box that contains no point.
    pub const EMPTY: Self = Self {
        low: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Bounding box of `points`.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.with(point))
    }

    /// Smallest box that contains this one and `point`.
    pub fn with(&self, point: &Point3<f64>) -> Self {
        Self { low: self.low.inf(point), high: self.high.sup(point) }
    }

    /// Extents of the box.
    pub fn diagonal(&self) -> Vector3<f64> {
        self.high - self.low
    }

    /// Returns true if the boxes overlap or touch.
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    /// Returns true if `other` lies in this box.
    pub fn contains(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }

    /// Squared distance of a point from the box; 0 inside.
    pub fn distance_squared(&self, point: &Point3<f64>) -> f64 {
        let axis = |k: usize| (self.low[k] - point[k]).max(point[k] - self.high[k]).max(0.0);
        let (x, y, z) = (axis(0), axis(1), axis(2));
        x * x + y * y + z * z
    }
}

/// Node of the hierarchy. Its left child follows it, its right child has index `right`; 0 marks a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Bounding box of its triangles.
    pub bounds: BoundingBox,
    /// Index of its first triangle, in the tree's order.
    pub first: u32,
    /// Number of its triangles.
    pub count: u32,
    /// Index of its right child; 0 for a leaf.
    pub right: u32,
}

impl Node {
    /// Returns true if it has no children.
    pub fn is_leaf(&self) -> bool {
        self.right == 0
    }

    /// Its triangles, as a range in the tree's order.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Bounding-box hierarchy. Triangles are stored in leaf order.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleTree {
    /// Nodes in depth-first order, the root first.
    pub nodes: Vec<Node>,
    /// Corners of the triangles, in leaf order.
    pub triangles: Vec<[Point3<f64>; 3]>,
    /// Index of each stored triangle in the list given to [`TriangleTree::new`].
    pub order: Vec<u32>,
}

impl TriangleTree {
    /// Builds the hierarchy in O(n log n). An empty list yields no nodes.
    pub fn new(triangles: &[[Point3<f64>; 3]]) -> Self {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let centers: Vec<Point3<f64>> =
            triangles.iter().map(|[a, b, c]| Point3::from((a.coords + b.coords + c.coords) / 3.0)).collect();
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        if !triangles.is_empty() {
            split(&mut nodes, &mut order, 0, triangles, &centers);
        }
        let triangles = order.iter().map(|&triangle| triangles[triangle as usize]).collect();
        Self { nodes, triangles, order }
    }

    /// Calls `visit` for every triangle stored at index `first` or later whose box overlaps `bounds`.
    pub fn overlapping(&self, bounds: &BoundingBox, first: usize, mut visit: impl FnMut(usize)) {
        let mut stack = [0u32; STACK];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let index = stack[top];
            let node = &self.nodes[index as usize];
            if node.range().end <= first || !node.bounds.overlaps(bounds) {
                continue;
            }
            if !node.is_leaf() {
                stack[top] = node.right;
                stack[top + 1] = index + 1;
                top += 2;
                continue;
            }
            for place in node.range().filter(|&place| place >= first) {
                if BoundingBox::of(&self.triangles[place]).overlaps(bounds) {
                    visit(place);
                }
            }
        }
    }
}

fn split(
    nodes: &mut Vec<Node>,
    order: &mut [u32],
    first: usize,
    triangles: &[[Point3<f64>; 3]],
    centers: &[Point3<f64>],
) {
    let bounds = BoundingBox::of(order.iter().flat_map(|&t| &triangles[t as usize]));
    let index = nodes.len();
    nodes.push(Node { bounds, first: first as u32, count: order.len() as u32, right: 0 });
    if order.len() <= LEAF {
        return;
    }
    let axis = BoundingBox::of(order.iter().map(|&t| &centers[t as usize])).diagonal().imax();
    let middle = order.len() / 2;
    let key = |t: &u32| centers[*t as usize][axis];
    order.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(middle);
    split(nodes, left, first, triangles, centers);
    nodes[index].right = nodes.len() as u32;
    split(nodes, right, first + middle, triangles, centers);
}
