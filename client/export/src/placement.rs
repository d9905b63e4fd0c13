//! Translations of nodes, which glTF stores in single precision.

use super::FragmentView;
use serde_json::ser::{CompactFormatter, Formatter};
use std::io::{self, Write};

/// Largest rounding unit of a node's translation, relative to the extent of all fragments.
///
/// Rounding displaces a fragment by at most half a unit per axis, two millionths of the extent. Objects within thirty times their extent of
/// the origin stay below this limit, so their nodes have no parent.
const ROUNDING_MAX: f64 = 1.0 / (1_u64 << 18) as f64;

/// Positions of fragments in the scene.
pub(super) struct Placement {
    /// Translation of the common parent of all nodes, m; `None` if the nodes have no parent.
    pub origin_m: Option<[f32; 3]>,
}

impl Placement {
    /// Places nodes in the scene, or relative to the center of all fragments if rounding would displace them noticeably.
    pub(super) fn of(fragments: &[FragmentView<'_>]) -> Self {
        let (low, high) = bounds(fragments.iter().flat_map(|fragment| {
            let center_m = fragment.center_m;
            fragment.positions.iter().map(move |own| [0, 1, 2].map(|k| center_m[k] + f64::from(own[k])))
        }));
        let extent_m = [0, 1, 2].map(|k| high[k] - low[k]).into_iter().fold(0.0, f64::max);
        let (low, high) = bounds(fragments.iter().map(|fragment| fragment.center_m));
        let largest = low.iter().chain(&high).fold(0.0, |largest: f64, x| largest.max(x.abs())) as f32;
        let is_far = f64::from(largest.next_up() - largest) > ROUNDING_MAX * extent_m;
        Self { origin_m: is_far.then(|| [0, 1, 2].map(|k| (0.5 * (low[k] + high[k])) as f32)) }
    }

    /// Translation of the node of a fragment with this center, m, relative to the parent if there is one.
    pub(super) fn translation(&self, center_m: [f64; 3]) -> [f32; 3] {
        let origin_m = self.origin_m.unwrap_or_default();
        [0, 1, 2].map(|k| (center_m[k] - f64::from(origin_m[k])) as f32)
    }
}

/// Lowest and highest coordinates of points.
fn bounds(points: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    points.fold(start, |(low, high), point| {
        ([0, 1, 2].map(|k| low[k].min(point[k])), [0, 1, 2].map(|k| high[k].max(point[k])))
    })
}

/// JSON with single-precision numbers in full: 500000.03125, not the shortest form 500000.03, which a reader with double precision
/// takes for another number.
pub(super) struct ExactSingles;

impl Formatter for ExactSingles {
    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, value: f32) -> io::Result<()> {
        CompactFormatter.write_f64(writer, f64::from(value))
    }
}
