//! Attributes of mesh triangles: normals, texture coordinates, colors and materials.

use crate::scene::brief;

/// Index of a triangle without a material.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Largest accepted texture coordinate. Interpolation between larger ones would overflow single precision.
pub const UV_MAX: f32 = 1e9;

/// Largest distance of a channel of a color from the range 0 to 1 that is rounding.
const COLOR_ROUNDING: f32 = 1e-3;

const _: () = assert!(UV_MAX == 1e9, "`TriangleAttributes::range` says so");

/// Normals, texture coordinates, colors and materials per triangle.
///
/// A list is empty if the file lacks the attribute for any triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleAttributes {
    /// Unit normals of the three corners, y up.
    pub normals: Vec<[[f32; 3]; 3]>,
    /// Texture coordinates of the three corners, v up: as in OBJ and PLY files, and (u, 1 − v) of glTF's.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// Second texture coordinates of the three corners, v up: (u, 1 − v) of glTF's `TEXCOORD_1`.
    pub uvs2: Vec<[[f32; 2]; 3]>,
    /// Red, green, blue and alpha of the three corners, from 0 to 1: linear in glTF files, and as they are in OBJ and PLY
    /// files. Alpha is 1 if the file has none.
    pub colors: Vec<[[f32; 4]; 3]>,
    /// Index of each triangle's material in `names`, or [`NO_MATERIAL`].
    pub materials: Vec<u32>,
    /// Names of the materials, in the file's order.
    pub names: Vec<String>,
    /// Dropped attributes, each with the first triangle that lacks a valid value.
    pub lost: Vec<(&'static str, u32)>,
}

impl TriangleAttributes {
    /// Attributes of triangles from attributes of their vertices. Drops those that some vertex lacks.
    pub(super) fn of_vertices(triangles: &[[u32; 3]], of: &VertexLists) -> Self {
        fn corners<T: Copy>(triangles: &[[u32; 3]], of: &[T]) -> Vec<[T; 3]> {
            let known = triangles.iter().flatten().all(|&vertex| (vertex as usize) < of.len());
            if known { triangles.iter().map(|own| own.map(|vertex| of[vertex as usize])).collect() } else { Vec::new() }
        }
        Self {
            normals: corners(triangles, &of.normals),
            uvs: corners(triangles, &of.uvs),
            uvs2: corners(triangles, &of.uvs2),
            colors: corners(triangles, &of.colors),
            ..Self::default()
        }
    }

    /// Requirement on the values of a kind of [`Self::lost`], as the end of a sentence.
    pub(super) fn range(kind: &str) -> &'static str {
        match kind {
            "normals" => ", finite and not zero",
            "texture coordinates" | "second texture coordinates" => " from -1e9 to 1e9",
            "colors" => " from 0 to 1",
            _ => "",
        }
    }

    /// Drops the lists that are not valid for each of `triangles` triangles, normalizes the normals, and clamps the colors.
    #[must_use]
    pub fn fitting(mut self, triangles: usize) -> Self {
        let length = |normal: &[f32; 3]| normal.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        let is_direction = |normal: &[f32; 3]| length(normal).is_finite() && length(normal) > 0.0;
        if let Some(first) = unfit(&self.normals, triangles, |own| own.iter().all(is_direction)) {
            self.normals.clear();
            self.lost.push(("normals", first));
        }
        for normal in self.normals.iter_mut().flatten() {
            let length = length(normal);
            *normal = normal.map(|x| (f64::from(x) / length) as f32);
        }
        let is_channel = |x: &f32| (-COLOR_ROUNDING..=1.0 + COLOR_ROUNDING).contains(x);
        let sets = [("texture coordinates", &mut self.uvs), ("second texture coordinates", &mut self.uvs2)];
        for (name, uvs) in sets {
            if let Some(first) = unfit(uvs, triangles, |own| own.iter().flatten().all(|x| x.abs() <= UV_MAX)) {
                uvs.clear();
                self.lost.push((name, first));
            }
        }
        if let Some(first) = unfit(&self.colors, triangles, |own| own.iter().flatten().all(is_channel)) {
            self.colors.clear();
            self.lost.push(("colors", first));
        }
        self.colors.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|x| *x = x.clamp(0.0, 1.0));
        self.names.iter_mut().for_each(|name| *name = brief(name));
        let names = self.names.len() as u32;
        let is_known = |material: &u32| *material < names || *material == NO_MATERIAL;
        if let Some(first) = unfit(&self.materials, triangles, is_known) {
            (self.materials, self.names) = (Vec::new(), Vec::new());
            self.lost.push(("materials", first));
        }
        self
    }

    /// Attributes of the triangles `source`, in their order. The last two corners are exchanged where `turned`.
    #[must_use]
    pub(super) fn of(&self, source: &[u32], turned: &[bool]) -> Self {
        fn pick<T: Copy>(of: &[[T; 3]], source: &[u32], turned: &[bool]) -> Vec<[T; 3]> {
            let order = |(&triangle, &turned): (&u32, &bool)| {
                let [a, b, c] = of[triangle as usize];
                if turned { [a, c, b] } else { [a, b, c] }
            };
            if of.is_empty() { Vec::new() } else { source.iter().zip(turned).map(order).collect() }
        }
        let materials = match self.materials.is_empty() {
            true => Vec::new(),
            false => source.iter().map(|&triangle| self.materials[triangle as usize]).collect(),
        };
        Self {
            normals: pick(&self.normals, source, turned),
            uvs: pick(&self.uvs, source, turned),
            uvs2: pick(&self.uvs2, source, turned),
            colors: pick(&self.colors, source, turned),
            materials,
            names: self.names.clone(),
            lost: self.lost.clone(),
        }
    }
}

/// Attributes of the vertices of a file; a list is empty if it has none.
#[derive(Debug, Default)]
pub(super) struct VertexLists {
    /// Normals of any length.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v up.
    pub uvs: Vec<[f32; 2]>,
    /// Second texture coordinates, v up.
    pub uvs2: Vec<[f32; 2]>,
    /// Red, green, blue and alpha, from 0 to 1.
    pub colors: Vec<[f32; 4]>,
}

/// First of `triangles` triangles whose entry is missing or invalid. `None` for an empty list.
fn unfit<T>(list: &[T], triangles: usize, fits: impl Fn(&T) -> bool) -> Option<u32> {
    let first =
        || list.iter().position(|own| !fits(own)).or((list.len() != triangles).then_some(list.len().min(triangles)));
    if list.is_empty() { None } else { first().map(|first| first as u32) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> TriangleAttributes {
        let normals = vec![[[0.0, 0.0, 2.0]; 3], [[3.0, 0.0, 0.0]; 3]];
        let uvs = vec![[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]; 2];
        let names = vec!["a".into(), "b".into()];
        let (uvs2, colors) = (vec![[[0.5; 2]; 3]; 2], vec![[[0.1; 4], [0.5; 4], [1.0005; 4]]; 2]);
        TriangleAttributes { normals, uvs, uvs2, colors, materials: vec![1, NO_MATERIAL], names, lost: Vec::new() }
    }

    #[test]
    fn attributes_of_only_some_triangles_are_dropped() {
        let fitting = full().fitting(2);
        assert_eq!(fitting.normals[1], [[1.0, 0.0, 0.0]; 3]);
        assert_eq!((fitting.uvs.len(), fitting.uvs2.len(), fitting.materials.len()), (2, 2, 2));
        assert_eq!(fitting.colors[0], [[0.1; 4], [0.5; 4], [1.0; 4]]);
        let lost = ["normals", "texture coordinates", "second texture coordinates", "colors", "materials"];
        let lost = lost.map(|name| (name, 2)).to_vec();
        assert_eq!(full().fitting(3), TriangleAttributes { lost, ..TriangleAttributes::default() });
        let damaged = |damage: fn(&mut TriangleAttributes)| {
            let mut attributes = full();
            damage(&mut attributes);
            attributes.fitting(2)
        };
        assert!(damaged(|attributes| attributes.normals[1][2] = [0.0; 3]).normals.is_empty());
        assert_eq!(damaged(|attributes| attributes.normals[1][2] = [0.0; 3]).lost, [("normals", 1)]);
        assert!(damaged(|attributes| attributes.uvs[0][0][1] = f32::NAN).uvs.is_empty());
        assert!(damaged(|attributes| attributes.uvs[0][0][1] = 1e38).uvs.is_empty());
        let second = damaged(|attributes| attributes.uvs2[1][0][1] = f32::NAN);
        assert_eq!((second.uvs.len(), second.uvs2.len(), second.lost), (2, 0, vec![("second texture coordinates", 1)]));
        for value in [f32::NAN, 1.01, -0.01, 255.0] {
            let mut attributes = full();
            attributes.colors[0][2][3] = value;
            assert_eq!(attributes.fitting(2).lost, [("colors", 0)], "{value}");
        }
        assert!(damaged(|attributes| attributes.materials[0] = 2).names.is_empty());
    }

    #[test]
    fn turned_triangles_exchange_their_corners() {
        let taken = full().of(&[1, 0, 1], &[false, true, false]);
        assert_eq!(taken.materials, [NO_MATERIAL, 1, NO_MATERIAL]);
        assert_eq!(taken.uvs[1], [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        assert_eq!(taken.colors[1], [[0.1; 4], [1.0005; 4], [0.5; 4]]);
        assert_eq!(TriangleAttributes::default().of(&[0], &[true]), TriangleAttributes::default());
    }
}
