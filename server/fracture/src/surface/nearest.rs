//! Which of many points is nearest.

use super::closest;
use super::tree::Tree;
use nalgebra::Point3;

/// Points that can be asked which of them is nearest to another.
pub struct Nearest(Tree);

impl Nearest {
    /// Of these points.
    pub fn new(points: &[Point3<f64>]) -> Self {
        let triangles: Vec<[Point3<f64>; 3]> = points.iter().map(|point| [*point; 3]).collect();
        Self(Tree::new(&triangles))
    }

    /// The place of the point nearest to `point` in their list; 0 without points.
    pub fn to(&self, point: &Point3<f64>) -> usize {
        closest::nearest(&self.0, point).1 as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn the_nearest_is_the_one_that_a_search_through_all_finds() {
        let mut random = Stream::new(7, 7);
        let mut point = || Point3::new(random.uniform(), random.uniform(), random.uniform());
        let points: Vec<Point3<f64>> = (0..300).map(|_| point()).collect();
        let nearest = Nearest::new(&points);
        for _ in 0..300 {
            let at = point();
            let distance = |index: usize| (points[index] - at).norm_squared();
            let best = (0..points.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap();
            assert_eq!(nearest.to(&at), best);
        }
    }
}
