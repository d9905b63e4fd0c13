//! Boxes whose sides do not lie along the axes.

use nalgebra::{Point3, Rotation3, Vector3};

/// Box with sides along the columns of a rotation, in local lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnedBox {
    /// Rotation from coordinates of the box to local ones.
    pub turn: Rotation3<f64>,
    /// Lowest corner in coordinates of the box.
    pub low: Point3<f64>,
    /// Highest corner in coordinates of the box.
    pub high: Point3<f64>,
}

impl TurnedBox {
    /// Smallest box in these directions around `points`.
    pub fn around<'a>(turn: Rotation3<f64>, points: impl IntoIterator<Item = &'a Point3<f64>>) -> Self {
        let start = [f64::INFINITY, f64::NEG_INFINITY].map(|bound| Point3::from(Vector3::repeat(bound)));
        let [low, high] = points.into_iter().fold(start, |[low, high], point| {
            let own = turn.inverse_transform_point(point);
            [low.inf(&own), high.sup(&own)]
        });
        Self { turn, low, high }
    }

    /// Lengths of the sides.
    pub fn extent(&self) -> Vector3<f64> {
        self.high - self.low
    }
}
