//! Conversion of fragments to result sections, in the convention of the request, and of contacts from it.

use super::engine_error;
use nalgebra::Vector3;
use shatter_fracture::pipeline::{
    self, BondRow, DebrisRow, FractureMeshes, FragmentRow, HullRow, OuterVertexAttributes, ReleaseVelocity, RunRow,
    SkinRow, SkinVertexRow, StageObserver,
};
use shatter_fracture::scene::EffectKind;
use shatter_fracture::tessellation::HostFrame;
use shatter_proto::Error;
use shatter_proto::convention::Convention;
use shatter_proto::layout::{SectionCounts, SectionsMut};
use shatter_proto::request::{Contact, ContactPartner};
use shatter_proto::result::{
    BondWire, DebrisWire, FragmentVelocity, FragmentWire, HullWire, OuterAttributes, RunWire, SkinVertex, SkinWire,
};

/// Converts a contact of a request in the convention `from`.
pub(super) fn contact(own: &Contact, from: &Convention) -> pipeline::ImpactContact {
    pipeline::ImpactContact {
        point_m: from.our_vector(own.point_m).into(),
        impulse_ns: from.our_vector(own.impulse_ns).into(),
        duration_s: own.duration_s,
        radius_m: own.radius_m.map(|units| from.meters(units)),
        partner: own.partner.map(|partner| self::partner(&partner, from)),
    }
}

/// Converts the partner of a contact in the convention `from`.
fn partner(own: &ContactPartner, from: &Convention) -> pipeline::ImpactPartner {
    pipeline::ImpactPartner {
        id: own.id,
        mass_kg: own.mass_kg,
        center_m: from.our_vector(own.center_m).into(),
        inertia_kg_m2: from.our_inertia(own.inertia_kg_m2),
        speed_m_s: from.meters(own.speed_m_s),
    }
}

/// Elements per section of a result with these fragments.
pub(super) fn counts(pieces: &FractureMeshes) -> SectionCounts {
    SectionCounts {
        fragments: pieces.fragments.len(),
        runs: pieces.runs.len(),
        merges: pieces.counts.merges,
        vertices: pieces.counts.vertices,
        indices: pieces.counts.indices,
        velocities: pieces.velocities.len(),
        normals: if pieces.effects.has(EffectKind::Normals) { pieces.counts.vertices } else { 0 },
        uvs: if pieces.effects.has(EffectKind::Uv) { pieces.counts.vertices } else { 0 },
        bonds: pieces.bond_count(),
        debris: pieces.debris_count(),
        hulls: pieces.hulls.rows.len(),
        hull_vertices: pieces.hulls.positions.len(),
        hull_indices: pieces.hulls.indices.len(),
        outer_attributes: pieces.attributes.vertices.len(),
        materials: pieces.attributes.materials.len(),
        skins: pieces.skins.rows.len(),
        skin_vertices: pieces.skins.vertices.len(),
        skin_indices: pieces.skins.indices.len(),
        skin_materials: pieces.skins.materials.len(),
        outer_uvs2: pieces.attributes.uvs2.len(),
        outer_colors: pieces.attributes.colors.len(),
        skin_uvs2: pieces.skins.uvs2.len(),
        skin_colors: pieces.skins.colors.len(),
    }
}

/// Coordinates in the convention of a host.
struct HostCoordinates<'a>(&'a Convention);

impl HostFrame for HostCoordinates<'_> {
    fn offset(&self, meters: Vector3<f64>) -> [f32; 3] {
        single(self.0.vector(meters.into()))
    }

    fn direction(&self, ours: Vector3<f64>) -> [f32; 3] {
        single(self.0.direction(ours.into()))
    }

    fn is_clockwise(&self) -> bool {
        self.0.is_clockwise()
    }
}

fn single(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|x| x as f32)
}

/// Writer of fragments in a convention.
pub(super) struct Writer<'a> {
    pub pieces: &'a FractureMeshes,
    pub to: &'a Convention,
}

impl Writer<'_> {
    /// Writes all sections but the summary, the stages and the effects; reports the effects that are computed here to `observer`.
    ///
    /// # Errors
    /// `failed` if a section has another length.
    pub fn write(&self, sections: &mut SectionsMut<'_>, observer: &dyn StageObserver) -> Result<(), Error> {
        let Self { pieces, to } = self;
        fill(sections.fragments, &pieces.fragments, |row| fragment(row, to));
        fill(sections.runs, &pieces.runs, run);
        // The default convention has a separate path without conversion.
        let written = match to.is_default() {
            true => pieces.emit(sections.positions, sections.indices, sections.merges),
            false => pieces.emit_for(&HostCoordinates(to), sections.positions, sections.indices, sections.merges),
        };
        written.map_err(engine_error)?;
        self.write_optional_sections(sections);
        self.effects(sections, observer);
        Ok(())
    }

    /// Writes the data that was computed with the fragments.
    fn write_optional_sections(&self, sections: &mut SectionsMut<'_>) {
        let Self { pieces, to } = self;
        fill(sections.velocities, &pieces.velocities, |own| velocity(own, to));
        fill(sections.hulls, &pieces.hulls.rows, |own| hull(own, to));
        fill(sections.hull_positions, &pieces.hulls.positions, |own| to.vector_f32(*own));
        self.triangles(sections.hull_indices, &pieces.hulls.indices);
        fill(sections.outer_attributes, &pieces.attributes.vertices, |own| outer_attributes(own, to));
        fill(sections.outer_uvs2, &pieces.attributes.uvs2, |own| *own);
        fill(sections.outer_colors, &pieces.attributes.colors, |own| *own);
        fill(sections.materials, &pieces.attributes.materials, |own| *own);
        fill(sections.skins, &pieces.skins.rows, skin);
        fill(sections.skin_vertices, &pieces.skins.vertices, |own| skin_vertex(own, to));
        if pieces.has_exact_surface() {
            self.share_positions(sections);
        }
        self.triangles(sections.skin_indices, &pieces.skins.indices);
        fill(sections.skin_materials, &pieces.skins.materials, |own| *own);
        fill(sections.skin_uvs2, &pieces.skins.uvs2, |own| *own);
        fill(sections.skin_colors, &pieces.skins.colors, |own| *own);
    }

    /// Gives the vertices of skins on the input surface exactly the positions of the outer runs, which come first.
    fn share_positions(&self, sections: &mut SectionsMut<'_>) {
        for (skin, fragment) in self.pieces.skins.rows.iter().zip(&self.pieces.fragments) {
            let own = &mut sections.skin_vertices[skin.vertex_first as usize..][..skin.vertex_count as usize];
            let positions = &sections.positions[fragment.vertex_first as usize..];
            own.iter_mut().zip(positions).for_each(|(own, position)| own.position_m = *position);
        }
    }

    /// Writes triangles in the winding order of the convention.
    fn triangles(&self, wire: &mut [u32], own: &[u32]) {
        let (wire, own) = (wire.as_chunks_mut::<3>().0, own.as_chunks::<3>().0);
        match self.to.is_clockwise() {
            true => fill(wire, own, |&[a, b, c]| [a, c, b]),
            false => fill(wire, own, |triangle| *triangle),
        }
    }

    /// Computes and writes the remaining effects.
    fn effects(&self, sections: &mut SectionsMut<'_>, observer: &dyn StageObserver) {
        let Self { pieces, to } = self;
        let effect = |effect: EffectKind, write: &mut dyn FnMut() -> usize| {
            if pieces.effects.has(effect) {
                let span = observer.effect(effect);
                span.produced_bytes(write() as u64);
            }
        };
        effect(EffectKind::Normals, &mut || {
            match to.is_default() {
                true => pieces.normals(sections.normals),
                false => pieces.normals_for(&HostCoordinates(to), sections.normals),
            }
            size_of_val(sections.normals)
        });
        effect(EffectKind::Uv, &mut || {
            pieces.uvs(sections.uvs);
            size_of_val(sections.uvs)
        });
        effect(EffectKind::Bonds, &mut || {
            fill(sections.bonds, &pieces.bonds(), |own| bond(own, to));
            size_of_val(sections.bonds)
        });
        effect(EffectKind::Debris, &mut || {
            fill(sections.debris, &pieces.debris(), |own| debris(own, to));
            size_of_val(sections.debris)
        });
    }
}

/// Converts each element into its row.
fn fill<W, O>(wire: &mut [W], own: &[O], row: impl Fn(&O) -> W) {
    wire.iter_mut().zip(own).for_each(|(wire, own)| *wire = row(own));
}

fn velocity(own: &ReleaseVelocity, to: &Convention) -> FragmentVelocity {
    let ReleaseVelocity { linear_m_s, angular_rad_s } = *own;
    FragmentVelocity { linear_m_s: to.vector(linear_m_s.into()), angular_rad_s: to.axial(angular_rad_s.into()) }
}

fn bond(own: &BondRow, to: &Convention) -> BondWire {
    BondWire {
        fragments: own.fragments,
        area_m2: to.square(own.area_m2),
        normal: to.direction(own.normal.into()),
        centroid_m: to.vector(own.centroid_m.coords.into()),
    }
}

fn debris(own: &DebrisRow, to: &Convention) -> DebrisWire {
    DebrisWire {
        fragment: own.fragment,
        neighbor: own.neighbor,
        position_m: single(to.vector(own.position_m.into())),
        normal: single(to.direction(own.normal.into())),
        size_m: to.length(own.size_m) as f32,
        reserved: 0,
    }
}

fn hull(own: &HullRow, to: &Convention) -> HullWire {
    let HullRow { vertex_first, vertex_count, index_first, index_count, coverage, margin_m } = *own;
    HullWire { vertex_first, vertex_count, index_first, index_count, coverage, margin_m: to.length(margin_m) }
}

fn outer_attributes(own: &OuterVertexAttributes, to: &Convention) -> OuterAttributes {
    OuterAttributes { normal: to.direction(own.normal), uv: own.uv }
}

fn skin(own: &SkinRow) -> SkinWire {
    let SkinRow { vertex_first, vertex_count, index_first, index_count } = *own;
    SkinWire { vertex_first, vertex_count, index_first, index_count }
}

fn skin_vertex(own: &SkinVertexRow, to: &Convention) -> SkinVertex {
    SkinVertex { position_m: to.vector_f32(own.position_m), normal: to.direction(own.normal), uv: own.uv }
}

fn fragment(row: &FragmentRow, to: &Convention) -> FragmentWire {
    FragmentWire {
        id: row.id,
        body: row.body,
        vertex_first: row.vertex_first,
        vertex_count: row.vertex_count,
        index_first: row.index_first,
        index_count: row.index_count,
        run_first: row.run_first,
        run_count: row.run_count,
        merge_first: row.merge_first,
        merge_count: row.merge_count,
        reserved: [0; 2],
        volume_m3: to.cube(row.volume_m3),
        mass_kg: row.mass_kg,
        center_m: to.vector(row.center_m),
        inertia_kg_m2: to.inertia(row.inertia_kg_m2),
        energy_j_m2: row.energy_j_m2,
    }
}

fn run(row: &RunRow) -> RunWire {
    RunWire {
        fragment: row.fragment,
        neighbor: row.neighbor,
        vertex_first: row.vertex_first,
        vertex_count: row.vertex_count,
        index_first: row.index_first,
        index_count: row.index_count,
        material: u32::from(row.crack),
        reserved: 0,
    }
}
