//! The skins of the fragments, if they are asked for: the input's triangles, cut where the cells' borders meet them.

use super::pieces::Broken;
use super::{Pieces, StrikeError, Watch};
use crate::scene::Effect;
use crate::skin::{Blend, Skin, Worn, worn};
use crate::tessellation::Sites;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// The skin of one fragment; nothing where no part of the input's surface is its.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkinRow {
    /// First vertex in [`Skins::vertices`].
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in [`Skins::indices`].
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
}

/// A vertex of a skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinVertex {
    /// Relative to the fragment's centre of mass, m.
    pub position_m: [f32; 3],
    /// Of length one.
    pub normal: [f32; 3],
    /// Texture coordinates, as in the input; zero where it has none.
    pub uv: [f32; 2],
}

/// The skins of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skins {
    /// One per fragment.
    pub rows: Vec<SkinRow>,
    /// Vertices, by fragment.
    pub vertices: Vec<SkinVertex>,
    /// Relative to the fragment's first vertex, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// One per triangle: a material of the input; empty if it has none.
    pub materials: Vec<u32>,
}

impl Skins {
    /// Bytes of the tables.
    fn bytes(&self) -> usize {
        let Self { rows, vertices, indices, materials } = self;
        let tables = size_of_val(rows.as_slice()) + size_of_val(vertices.as_slice());
        tables + size_of_val(indices.as_slice()) + size_of_val(materials.as_slice())
    }
}

impl Pieces {
    /// The same with skins of the fragments, if they are asked for.
    pub(super) fn with_skins(mut self, broken: &Broken<'_>, watch: &mut dyn Watch) -> Result<Self, StrikeError> {
        if self.effects.has(Effect::Skin) {
            watch.begin(Effect::Skin);
            let skin = broken.prepared.skin.as_ref().ok_or(StrikeError::Bare { effect: Effect::Skin })?;
            self.skins = self.dress(skin, broken)?;
            watch.end(Effect::Skin, self.skins.bytes() as u64);
        }
        Ok(self)
    }

    fn dress(&self, skin: &Skin, broken: &Broken<'_>) -> Result<Skins, StrikeError> {
        let tailor = Tailor::new(self, skin, broken)?;
        let labels: Vec<u32> = (0..skin.points.len() as u32).into_par_iter().map(|point| tailor.label(point)).collect();
        let parts = worn(skin, &labels, self.fragments.len(), |point, a, b| tailor.rival(point, a, b));
        let centres = self.bodies.iter().flat_map(|pieces| &pieces.properties).map(|own| own.centre);
        let mut skins = Skins::default();
        for (part, centre) in parts.iter().zip(centres) {
            skins.push(part, skin, &centre, self.transform.metres_per_unit);
        }
        Ok(skins)
    }
}

impl Skins {
    fn push(&mut self, part: &Worn, skin: &Skin, centre: &Point3<f64>, metre: f64) {
        self.rows.push(SkinRow {
            vertex_first: self.vertices.len() as u32,
            vertex_count: part.vertices.len() as u32,
            index_first: self.indices.len() as u32,
            index_count: 3 * part.triangles.len() as u32,
        });
        self.vertices.extend(part.vertices.iter().map(|blend| vertex(blend, skin, centre, metre)));
        self.indices.extend_from_slice(part.triangles.as_flattened());
        if !skin.materials.is_empty() {
            self.materials.extend(part.sources.iter().map(|&source| skin.materials[source as usize]));
        }
    }
}

fn vertex(blend: &Blend, skin: &Skin, centre: &Point3<f64>, metre: f64) -> SkinVertex {
    let own = blend.of.map(|vertex| &skin.vertices[vertex as usize]);
    let mean = |of: &dyn Fn(usize) -> Vector3<f64>| (0..3).map(|k| of(k) * blend.weights[k]).sum::<Vector3<f64>>();
    let single = |vector: Vector3<f64>| -> [f32; 3] { vector.map(|x| x as f32).into() };
    let offset = mean(&|k| skin.points[own[k].point as usize] - centre) * metre;
    let normal = mean(&|k| Vector3::from(own[k].normal).cast()).try_normalize(0.0);
    let uv = |axis: usize| (0..3).map(|k| f64::from(own[k].uv[axis]) * blend.weights[k]).sum::<f64>() as f32;
    SkinVertex { position_m: single(offset), normal: normal.map_or(own[0].normal, single), uv: [uv(0), uv(1)] }
}

/// Who wears what.
struct Tailor<'a> {
    pieces: &'a Pieces,
    skin: &'a Skin,
    broken: &'a Broken<'a>,
    /// By body: number of its first fragment.
    firsts: Vec<u32>,
    /// By body: its diagram, if it has one.
    sites: Vec<Option<Sites<'a>>>,
}

impl<'a> Tailor<'a> {
    fn new(pieces: &'a Pieces, skin: &'a Skin, broken: &'a Broken<'a>) -> Result<Self, StrikeError> {
        let (mut firsts, mut sites, mut first) = (Vec::new(), Vec::new(), 0);
        for own in &pieces.bodies {
            firsts.push(first);
            first += own.properties.len() as u32;
            let lift = broken.prepared.lift_for(own.body, broken.strike)?;
            let cells = broken.cells(own.body);
            sites.push(cells.map(|cells| Sites { lift, coordinates: &cells.diagram.sites, of_fragment: &own.sites }));
        }
        Ok(Self { pieces, skin, broken, firsts, sites })
    }

    /// The fragment that wears a point: of those that the tetrahedron around it has corners in, the one in whose cell it lies.
    fn label(&self, point: u32) -> u32 {
        let spot = &self.skin.spots[point as usize];
        let (body, labels) = (spot.body as usize, &self.pieces.bodies[spot.body as usize].labels);
        let nodes = self.broken.prepared.bodies[body].crack.tets[spot.place.tet as usize];
        let [first, others @ ..] = nodes.map(|node| self.firsts[body] + labels[node as usize]);
        others.into_iter().fold(first, |best, other| {
            let rival = if other == best { 0.0 } else { self.rival(point, other, best) };
            if rival < 0.0 || (rival == 0.0 && other < best) { other } else { best }
        })
    }

    /// f_a − f_b at a point, not a number between bodies.
    fn rival(&self, point: u32, a: u32, b: u32) -> f64 {
        let spot = &self.skin.spots[point as usize];
        let body = spot.body as usize;
        let own = |fragment: u32| {
            let local = fragment.checked_sub(self.firsts[body])?;
            ((local as usize) < self.pieces.bodies[body].properties.len()).then_some(local)
        };
        let nodes = self.broken.prepared.bodies[body].crack.tets[spot.place.tet as usize];
        match (self.sites[body], own(a), own(b)) {
            (Some(sites), Some(a), Some(b)) => sites.rivalry(nodes, spot.place.barycentric, a, b),
            _ => f64::NAN,
        }
    }
}
