//! Placement of labels in a diagram, so that they cover neither each other nor the points.

/// Upper left and lower right corner, pixels.
type Rectangle = [[i32; 2]; 2];

/// Mean width of a letter and height of a line at the size of the labels, pixels.
const LETTER: [i32; 2] = [6, 12];

/// Distance from a point to its label, pixels.
const AWAY: i32 = 6;

/// Upper bound of the extent of a label, pixels.
const FAR: i32 = 1000;

/// Distance between the rectangles that cover a line, pixels.
const STEP: i32 = 3;

/// Occupied areas of a drawing.
#[derive(Default)]
pub(super) struct Labels {
    taken: Vec<Rectangle>,
}

impl Labels {
    /// Creates a placement that prefers labels between these corners.
    pub fn within(from: [i32; 2], to: [i32; 2]) -> Self {
        let [left, top] =
            [[[from[0] - FAR, from[1] - FAR], [from[0], to[1] + FAR]], [[from[0], from[1] - FAR], [to[0], from[1]]]];
        let [right, bottom] =
            [[[to[0], from[1] - FAR], [to[0] + FAR, to[1] + FAR]], [[from[0], to[1]], [to[0], to[1] + FAR]]];
        Self { taken: vec![left, top, right, bottom] }
    }

    /// Keeps a line free of labels, pixels.
    pub fn keep_free_along(&mut self, from: [i32; 2], to: [i32; 2]) {
        let steps = ((to[0] - from[0]).abs().max((to[1] - from[1]).abs()) / STEP).max(1);
        for step in 0..steps {
            let [x, y] = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * step / steps);
            self.keep_free([x - 1, y - 1], [x + 1, y + 1]);
        }
    }

    /// Keeps a rectangle free of labels, pixels.
    pub fn keep_free(&mut self, from: [i32; 2], to: [i32; 2]) {
        self.taken.push([from, to]);
    }

    /// Places the label of the point `at`; returns its upper left corner relative to `at`, of twelve candidates the one that covers least.
    pub fn put(&mut self, at: [i32; 2], label: &str) -> [i32; 2] {
        let size = [LETTER[0] * label.chars().count() as i32, LETTER[1]];
        let [right, left, middle] = [AWAY, -AWAY - size[0], -size[0] / 2];
        let [above, below, beside] = [-AWAY - size[1], AWAY, -size[1] / 2];
        let near = [[right, above], [right, below], [left, above], [left, below], [right, beside], [left, beside]];
        let far =
            [[middle, above], [middle, below], [right, 2 * above], [left, 2 * above], [right, -above], [left, -above]];
        let own = |corner: [i32; 2]| {
            let from = [at[0] + corner[0], at[1] + corner[1]];
            [from, [from[0] + size[0], from[1] + size[1]]]
        };
        let covered = |corner: &[i32; 2]| self.taken.iter().map(|other| shared(&own(*corner), other)).sum::<i32>();
        let best = near.into_iter().chain(far).min_by_key(covered).unwrap_or(near[0]);
        self.taken.push(own(best));
        best
    }
}

/// Common area of two rectangles, pixels.
fn shared([a, b]: &Rectangle, [c, d]: &Rectangle) -> i32 {
    let along = |axis: usize| (b[axis].min(d[axis]) - a[axis].max(c[axis])).max(0);
    along(0) * along(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearby_labels_do_not_overlap() {
        let mut labels = Labels::default();
        let places = [[100, 100], [104, 103], [110, 98], [103, 112], [99, 90]];
        places.iter().for_each(|[x, y]| labels.keep_free([x - 3, y - 3], [x + 3, y + 3]));
        for place in places {
            labels.put(place, "0.0010");
        }
        let all = &labels.taken[places.len()..];
        let apart = |k: usize| all[..k].iter().all(|other| shared(&all[k], other) == 0);
        assert!((0..all.len()).all(apart), "{all:?}");
    }

    #[test]
    fn a_label_alone_stands_above_to_the_right() {
        assert_eq!(Labels::default().put([50, 50], "game"), [AWAY, -AWAY - LETTER[1]]);
        let mut labels = Labels::default();
        labels.keep_free([50, 0], [500, 500]);
        assert_eq!(labels.put([50, 50], "game")[0], -AWAY - 4 * LETTER[0]);
    }
}
