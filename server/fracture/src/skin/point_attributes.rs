//! Attributes of the input at points of its surface: of one point, and of many in one list per kind.

use crate::memory::held;
use crate::surface::TriangleAttributes;
use nalgebra::Vector3;

/// Color where the input has none: renderers multiply by it.
const WHITE: [f32; 4] = [1.0; 4];

/// Attributes of the input at a point of its surface, in one of the triangles there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointAttributes {
    /// Unit normal.
    pub normal: [f32; 3],
    /// Both sets of texture coordinates, v up; zero if the file has none.
    pub uvs: [[f32; 2]; 2],
    /// Red, green, blue and alpha, from 0 to 1; white if the file has none.
    pub color: [f32; 4],
}

impl PointAttributes {
    /// Attributes of a point with this normal and nothing else of the input.
    pub fn plain(normal: [f32; 3]) -> Self {
        Self { normal, uvs: [[0.0; 2]; 2], color: WHITE }
    }

    /// Color as bytes, from 0 to 255, rounded to the nearest.
    pub fn color_bytes(&self) -> [u8; 4] {
        // The conversion saturates.
        self.color.map(|x| (x * 255.0).round() as u8)
    }

    /// Bits of all attributes as [`PointAttributeLists`] keep them.
    pub(crate) fn bits(&self) -> [u32; 8] {
        let ([x, y, z], [[s, t], [u, v]]) = (self.normal.map(f32::to_bits), self.uvs.map(|uv| uv.map(f32::to_bits)));
        [x, y, z, s, t, u, v, u32::from_le_bytes(self.color_bytes())]
    }
}

impl Default for PointAttributes {
    /// No normal either.
    fn default() -> Self {
        Self::plain([0.0; 3])
    }
}

/// Weighted mean of normals, made unit again, of texture coordinates and of colors. Opposite normals yield the first.
pub(crate) fn blended<const N: usize>(attributes: [PointAttributes; N], weights: [f64; N]) -> PointAttributes {
    let sum = |of: &dyn Fn(usize) -> f32| -> f64 { (0..N).map(|k| f64::from(of(k)) * weights[k]).sum() };
    let normal = Vector3::from([0, 1, 2].map(|axis| sum(&|k| attributes[k].normal[axis])));
    PointAttributes {
        normal: normal.try_normalize(0.0).map_or(attributes[0].normal, |normal| normal.map(|x| x as f32).into()),
        uvs: [0, 1].map(|set| [0, 1].map(|axis| sum(&|k| attributes[k].uvs[set][axis]) as f32)),
        color: [0, 1, 2, 3].map(|channel| sum(&|k| attributes[k].color[channel]) as f32),
    }
}

/// Attributes that an input has beside normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AttributeKinds {
    /// True for each set of texture coordinates that it has.
    pub uvs: [bool; 2],
    /// True if it has colors.
    pub colors: bool,
}

impl AttributeKinds {
    /// The kinds that a surface has.
    pub fn of(attributes: &TriangleAttributes) -> Self {
        let uvs = [&attributes.uvs, &attributes.uvs2].map(|set| !set.is_empty());
        Self { uvs, colors: !attributes.colors.is_empty() }
    }

    /// True if there are second texture coordinates or colors, which results keep in tables of their own.
    pub fn is_more_than_first_uvs(self) -> bool {
        self.uvs[1] || self.colors
    }

    /// The kinds of either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        let uvs = [0, 1].map(|set| self.uvs[set] || other.uvs[set]);
        Self { uvs, colors: self.colors || other.colors }
    }
}

/// Attributes of many points. A list has one entry per point, or none if the input lacks that kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointAttributeLists {
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Both sets of texture coordinates, v up.
    pub uvs: [Vec<[f32; 2]>; 2],
    /// Red, green, blue and alpha.
    pub colors: Vec<[u8; 4]>,
}

impl PointAttributeLists {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.normals.len()
    }

    /// True if there is no point.
    pub fn is_empty(&self) -> bool {
        self.normals.is_empty()
    }

    /// Kinds with an entry per point; none if there is no point.
    pub fn kinds(&self) -> AttributeKinds {
        AttributeKinds { uvs: self.uvs.each_ref().map(|set| !set.is_empty()), colors: !self.colors.is_empty() }
    }

    /// Adds a point with the attributes of these kinds.
    pub fn push(&mut self, point: &PointAttributes, kinds: AttributeKinds) {
        self.normals.push(point.normal);
        for ((list, uv), _) in self.uvs.iter_mut().zip(point.uvs).zip(kinds.uvs).filter(|(_, has)| *has) {
            list.push(uv);
        }
        if kinds.colors {
            self.colors.push(point.color_bytes());
        }
    }

    /// Attributes of point `index`, which must exist.
    pub fn get(&self, index: usize) -> PointAttributes {
        let color = self.colors.get(index).map_or(WHITE, |color| color.map(|x| f32::from(x) / 255.0));
        let uvs = self.uvs.each_ref().map(|set| set.get(index).copied().unwrap_or_default());
        PointAttributes { normal: self.normals[index], uvs, color }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { normals, uvs: [first, second], colors } = self;
        held(normals) + held(first) + held(second) + held(colors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_survive_storage_and_lists_without_a_kind_are_empty() {
        let mut lists = PointAttributeLists::default();
        let kinds = AttributeKinds { uvs: [false, true], colors: true };
        for byte in 0..=255u8 {
            let color = [byte, 255 - byte, 0, 255].map(|x| f32::from(x) / 255.0);
            let point = PointAttributes { color, ..PointAttributes::plain([0.0, 1.0, 0.0]) };
            lists.push(&point, kinds);
            assert_eq!(lists.get(lists.len() - 1), point);
        }
        assert_eq!((lists.kinds(), lists.uvs[0].len(), lists.uvs[1].len()), (kinds, 0, 256));
        assert_eq!(lists.colors[200], [200, 55, 0, 255]);
    }

    #[test]
    fn means_of_colors_are_linear_and_bytes_are_rounded() {
        let point = |red: f32, u: f32| PointAttributes {
            uvs: [[0.0; 2], [u, 1.0]],
            color: [red, 0.0, 1.0, 1.0],
            ..PointAttributes::default()
        };
        let mean = blended([point(0.2, 2.0), point(0.8, 4.0)], [0.25, 0.75]);
        assert_eq!((mean.uvs[1], mean.color_bytes()), ([3.5, 1.0], [166, 0, 255, 255]));
        assert_eq!(PointAttributes { color: [2.0, -1.0, f32::NAN, 0.5], ..mean }.color_bytes(), [255, 0, 0, 128]);
    }
}
