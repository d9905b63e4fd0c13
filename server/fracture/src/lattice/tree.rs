//! Tree of bounding boxes: queries for the boxes that contain a point and for the nearest item.

use nalgebra::{Point3, Vector3};

/// Largest number of items per leaf.
const LEAF: usize = 8;

/// Axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aabb {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Aabb {
    /// Bounding box of points.
    pub(super) fn around(points: &[Point3<f64>]) -> Self {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for point in points {
            low = low.inf(&point.coords);
            high = high.sup(&point.coords);
        }
        Self { low: Point3::from(low), high: Point3::from(high) }
    }

    fn join(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    fn center(&self, axis: usize) -> f64 {
        self.low[axis] + self.high[axis]
    }

    /// Squared distance to `point`; 0 inside.
    fn distance_squared(&self, point: &Point3<f64>) -> f64 {
        let clamped = point.coords.sup(&self.low.coords).inf(&self.high.coords);
        (point.coords - clamped).norm_squared()
    }
}

#[derive(Clone, Debug)]
struct Branch {
    bounds: Aabb,
    /// Items of a leaf. An inner branch's children are the next in the list, and `second`.
    items: std::ops::Range<u32>,
    second: Option<u32>,
}

/// Bounding-box tree, split at the median of the longest side. Equal input yields an equal tree.
#[derive(Clone, Debug)]
pub(super) struct AabbTree {
    branches: Vec<Branch>,
    items: Vec<u32>,
}

impl AabbTree {
    /// Builds a tree over the items 0 … with these boxes.
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let mut tree = Self { branches: Vec::new(), items: (0..boxes.len() as u32).collect() };
        if !boxes.is_empty() {
            tree.build(boxes, 0..boxes.len());
        }
        tree
    }

    fn build(&mut self, boxes: &[Aabb], range: std::ops::Range<usize>) {
        let items = &mut self.items[range.clone()];
        let bounds = items[1..].iter().fold(boxes[items[0] as usize], |sum, &item| sum.join(&boxes[item as usize]));
        let own = self.branches.len();
        let leaf = items.len() <= LEAF;
        let middle = items.len() / 2;
        if !leaf {
            let axis = (bounds.high - bounds.low).imax();
            let key = |item: &u32| boxes[*item as usize].center(axis);
            items.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        }
        self.branches.push(Branch { bounds, items: range.start as u32..range.end as u32, second: None });
        if !leaf {
            self.build(boxes, range.start..range.start + middle);
            self.branches[own].second = Some(self.branches.len() as u32);
            self.build(boxes, range.start + middle..range.end);
        }
    }

    /// Visits items by increasing distance of their branch's box, and returns the nearest item.
    ///
    /// `visit` takes an item and returns its squared distance (infinite to skip it). The search stops at boxes beyond
    /// the least distance so far. At a tie the first item visited wins.
    pub(super) fn nearest(
        &self,
        point: &Point3<f64>,
        limit_squared: f64,
        mut visit: impl FnMut(u32) -> f64,
    ) -> Option<u32> {
        let (mut best, mut found) = (limit_squared, None);
        let mut open: Vec<(f64, u32)> = Vec::with_capacity(64);
        if let Some(root) = self.branches.first() {
            open.push((root.bounds.distance_squared(point), 0));
        }
        while let Some((distance, at)) = open.pop() {
            if distance > best {
                continue;
            }
            let branch = &self.branches[at as usize];
            let Some(second) = branch.second else {
                for &item in &self.items[branch.items.start as usize..branch.items.end as usize] {
                    let distance = visit(item);
                    if distance < best || found.is_none() && distance <= best && distance.is_finite() {
                        (best, found) = (distance, Some(item));
                    }
                }
                continue;
            };
            let children =
                [at + 1, second].map(|child| (self.branches[child as usize].bounds.distance_squared(point), child));
            let [near, far] = if children[1].0 < children[0].0 { [children[1], children[0]] } else { children };
            open.extend([far, near]);
        }
        found
    }

    /// Visits the items whose own box may overlap `bounds`: those of every leaf whose box does.
    pub(super) fn overlapping(&self, bounds: &Aabb, mut visit: impl FnMut(u32)) {
        let mut open: Vec<u32> = Vec::with_capacity(64);
        open.extend((!self.branches.is_empty()).then_some(0));
        while let Some(at) = open.pop() {
            let branch = &self.branches[at as usize];
            if branch.bounds.overlaps(bounds) {
                match branch.second {
                    Some(second) => open.extend([second, at + 1]),
                    None => self.items[branch.items.start as usize..branch.items.end as usize]
                        .iter()
                        .for_each(|&item| visit(item)),
                }
            }
        }
    }

    /// Visits the items of all leaves whose box contains `point` or lies within `margin` of
    /// it, until `visit` returns true.
    pub(super) fn containing(&self, point: &Point3<f64>, margin: f64, mut visit: impl FnMut(u32) -> bool) {
        let mut open: Vec<u32> = Vec::with_capacity(64);
        open.extend((!self.branches.is_empty()).then_some(0));
        while let Some(at) = open.pop() {
            let branch = &self.branches[at as usize];
            if branch.bounds.distance_squared(point) > margin * margin {
                continue;
            }
            match branch.second {
                Some(second) => open.extend([second, at + 1]),
                None => {
                    for &item in &self.items[branch.items.start as usize..branch.items.end as usize] {
                        if visit(item) {
                            return;
                        }
                    }
                }
            }
        }
    }
}
