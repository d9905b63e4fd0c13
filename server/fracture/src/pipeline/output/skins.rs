//! Skins of the fragments, with the effect `skin`: the input's triangles, cut along the boundaries of cells.

use super::outer_attributes::OuterRunAttributes;
use super::skin_regions::SkinRegions;
use super::vertex_attributes::outer_kinds;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::skin::{AttributeKinds, ClippedSurface, PointAttributes, Skin, SkinPoint, clip};
use crate::tessellation::BisectorSites;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::sync::Arc;

/// Skin of one fragment; empty if no part of the input's surface belongs to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkinRow {
    /// First vertex in [`FragmentSkins::vertices`].
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in [`FragmentSkins::indices`].
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
}

/// Vertex of a skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinVertexRow {
    /// Position relative to the fragment's center of mass, m.
    pub position_m: [f32; 3],
    /// Unit normal.
    pub normal: [f32; 3],
    /// Texture coordinates of the input; zero if it has none.
    pub uv: [f32; 2],
}

/// Skins of all fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FragmentSkins {
    /// Rows, one per fragment.
    pub rows: Vec<SkinRow>,
    /// Vertices, by fragment.
    pub vertices: Vec<SkinVertexRow>,
    /// Second texture coordinates of the input, one per vertex; empty if it has none.
    pub uvs2: Vec<[f32; 2]>,
    /// Red, green, blue and alpha of the input, one per vertex; empty if it has none.
    pub colors: Vec<[u8; 4]>,
    /// Vertex indices relative to the fragment's first vertex, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// Material of the input for each triangle; empty if it has none.
    pub materials: Vec<u32>,
    /// Cut of the skins.
    pub(in crate::pipeline) cut: Option<SkinCut>,
}

/// Cut of a skin into those of fragments.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::pipeline) struct SkinCut {
    /// Skin that was cut.
    pub skin: Arc<Skin>,
    /// True if that is the object's own skin.
    pub whole: bool,
    /// Parts, one per fragment.
    pub parts: Vec<ClippedSurface>,
}

impl SkinCut {
    /// The skin of fragment `fragment`, which must exist.
    pub fn of(&self, fragment: u32) -> Skin {
        self.skin.part(&self.parts[fragment as usize])
    }
}

impl FragmentSkins {
    /// Size of the tables in bytes.
    pub(in crate::pipeline) fn bytes(&self) -> usize {
        let Self { rows, vertices, uvs2, colors, indices, materials, cut: _ } = self;
        let tables = size_of_val(rows.as_slice()) + size_of_val(vertices.as_slice());
        let optional = size_of_val(uvs2.as_slice()) + size_of_val(colors.as_slice());
        tables + optional + size_of_val(indices.as_slice()) + size_of_val(materials.as_slice())
    }
}

impl FragmentSkins {
    /// The skins of the fragments of `bodies`, cut from `skin`. `sites`: the diagram of each body, if it has one.
    pub(in crate::pipeline) fn clip(
        bodies: &[BodyMeshes],
        skin: &Arc<Skin>,
        context: RequestContext<'_>,
        sites: &[Option<BisectorSites<'_>>],
    ) -> Self {
        let (mut skins, prepared) = (Self::default(), context.prepared);
        let parts = SkinAssigner::new(bodies, skin, context, sites).cut();
        let centers = bodies.iter().flat_map(|pieces| &pieces.properties).map(|own| own.center);
        for (part, center) in parts.iter().zip(centers) {
            skins.push(part, skin, &center, prepared.frame.diagonal_m);
        }
        let whole = prepared.skin.as_ref().is_some_and(|own| Arc::ptr_eq(own, skin));
        skins.cut = Some(SkinCut { skin: skin.clone(), whole, parts });
        skins
    }
}

impl FragmentSkins {
    /// The skins of fragments whose outer runs are on the input surface and have `outer`, by body and fragment: the same
    /// vertices and triangles. `meter`: meters per local unit.
    pub(in crate::pipeline) fn of_outer_runs(
        bodies: &[BodyMeshes],
        outer: &[Vec<OuterRunAttributes>],
        meter: f64,
    ) -> Self {
        let (mut skins, kinds) = (Self::default(), outer_kinds(outer));
        for (pieces, outer) in bodies.iter().zip(outer) {
            for ((range, own), center) in pieces.tessellation.fragments().iter().zip(outer).zip(&pieces.centers) {
                let (vertex_first, index_first) = (skins.vertices.len() as u32, skins.indices.len() as u32);
                let runs = &pieces.tessellation.runs()[range.runs.clone()];
                if let Some(run) = runs.first().filter(|run| !run.crack) {
                    for (vertex, place) in pieces.tessellation.run_vertices(run).iter().enumerate() {
                        skins.add((place - center) * meter, &own.vertices.get(vertex), kinds);
                    }
                    skins.indices.extend(pieces.tessellation.run_triangles(run).flatten());
                    skins.materials.extend_from_slice(&own.materials);
                }
                let (vertex_count, index_count) =
                    (skins.vertices.len() as u32 - vertex_first, skins.indices.len() as u32 - index_first);
                skins.rows.push(SkinRow { vertex_first, vertex_count, index_first, index_count });
            }
        }
        skins
    }

    fn push(&mut self, part: &ClippedSurface, skin: &Skin, center: &Point3<f64>, meter: f64) {
        self.rows.push(SkinRow {
            vertex_first: self.vertices.len() as u32,
            vertex_count: part.vertices.len() as u32,
            index_first: self.indices.len() as u32,
            index_count: 3 * part.triangles.len() as u32,
        });
        let kinds = skin.attributes.kinds();
        for blend in &part.vertices {
            let (place, attributes) = blend.of(skin);
            self.add((place - center) * meter, &attributes, kinds);
        }
        self.indices.extend_from_slice(part.triangles.as_flattened());
        if !skin.materials.is_empty() {
            self.materials.extend(part.sources.iter().map(|&source| skin.materials[source as usize]));
        }
    }

    /// Adds a vertex. `offset_m`: from the fragment's center of mass, m.
    fn add(&mut self, offset_m: Vector3<f64>, point: &PointAttributes, kinds: AttributeKinds) {
        let position_m = offset_m.map(|x| x as f32).into();
        self.vertices.push(SkinVertexRow { position_m, normal: point.normal, uv: point.uvs[0] });
        self.uvs2.extend(kinds.uvs[1].then_some(point.uvs[1]));
        self.colors.extend(kinds.colors.then(|| point.color_bytes()));
    }
}

/// Assignment of skin points to fragments.
struct SkinAssigner<'a> {
    pieces: &'a [BodyMeshes],
    skin: &'a Skin,
    prepared: &'a PreparedObject,
    /// Diagram of each body of the result, if it has one.
    sites: &'a [Option<BisectorSites<'a>>],
    /// First fragment of each body of the result.
    firsts: Vec<u32>,
    /// Index in the result of each body of the object.
    places: Vec<usize>,
    /// Protected regions of each body of the result, if the request uses them.
    regions: Vec<Option<SkinRegions<'a>>>,
}

impl<'a> SkinAssigner<'a> {
    fn new(
        pieces: &'a [BodyMeshes],
        skin: &'a Skin,
        context: RequestContext<'a>,
        sites: &'a [Option<BisectorSites<'a>>],
    ) -> Self {
        let RequestContext { prepared, request, .. } = context;
        let (mut firsts, mut first, mut places) = (Vec::new(), 0, vec![0; prepared.bodies.len()]);
        for (place, own) in pieces.iter().enumerate() {
            firsts.push(first);
            first += own.properties.len() as u32;
            places[own.body] = place;
        }
        let regions = |own: &'a BodyMeshes| {
            let boundary = request.controls_of(prepared, own.body)?.boundary.as_ref()?;
            Some(SkinRegions::new(boundary, own))
        };
        let regions = pieces.iter().map(regions).collect();
        Self { pieces, skin, prepared, sites, firsts, places, regions }
    }

    fn cut(&self) -> Vec<ClippedSurface> {
        let labels: Vec<u32> =
            (0..self.skin.points.len() as u32).into_par_iter().map(|point| self.label(point)).collect();
        clip(self.skin, &labels, self.pieces.iter().map(|own| own.properties.len()).sum(), |point, a, b| {
            self.rival(point, a, b)
        })
    }

    /// Body of the result around a point, fragments at the corner nodes of its tetrahedron, and their weights.
    ///
    /// Nodes of fragments outside the result have no fragment and weight 0.
    fn around(&self, point: u32) -> (usize, [Option<u32>; 4], [f64; 4]) {
        let SkinPoint { body, place } = &self.skin.spots[point as usize];
        let own = self.places[*body as usize];
        let (pieces, nodes) = (&self.pieces[own], self.nodes(point));
        let is_kept = |label: &u32| (*label as usize) < pieces.properties.len();
        let fragments = nodes.map(|node| Some(pieces.labels[node as usize]).filter(is_kept));
        let weights = [0, 1, 2, 3].map(|k| if fragments[k].is_some() { place.barycentric[k] } else { 0.0 });
        (own, fragments.map(|label| Some(self.firsts[own] + label?)), weights)
    }

    /// Corner nodes of the tetrahedron around a point.
    fn nodes(&self, point: u32) -> [u32; 4] {
        let SkinPoint { body, place } = &self.skin.spots[point as usize];
        self.prepared.bodies[*body as usize].crack.tets[place.tet as usize]
    }

    /// The fragment of a point: that of the protected region around it, or, among those at the corners of its
    /// tetrahedron, the one whose cell contains the point.
    fn label(&self, point: u32) -> u32 {
        let (body, fragments, _) = self.around(point);
        let enclosing = self.regions[body]
            .as_ref()
            .and_then(|regions| regions.fragment(&self.skin.points[point as usize], self.nodes(point)));
        if let Some(enclosing) = enclosing {
            return self.firsts[body] + enclosing;
        }
        let nearer = |best: u32, other: u32| {
            let rival = if other == best { 0.0 } else { self.rival(point, other, best) };
            if rival < 0.0 || (rival == 0.0 && other < best) { other } else { best }
        };
        fragments.into_iter().flatten().reduce(nearer).unwrap_or(self.firsts[body])
    }

    /// Difference f_a − f_b at a point; NaN for fragments of different bodies.
    fn rival(&self, point: u32, a: u32, b: u32) -> f64 {
        let (body, _, weights) = self.around(point);
        let own = |fragment: u32| {
            let local = fragment.checked_sub(self.firsts[body])?;
            ((local as usize) < self.pieces[body].properties.len()).then_some(local)
        };
        let (Some(sites), Some(a), Some(b)) = (self.sites[body], own(a), own(b)) else { return f64::NAN };
        let natural = sites.rivalry(self.nodes(point), weights, a, b);
        match &self.regions[body] {
            Some(regions) => regions.rivalry(&self.skin.points[point as usize], [a, b], natural, &sites),
            None => natural,
        }
    }
}
