//! Every combination of sections that a valid result may have is written, or refused with an error: no panic.

use super::*;
use bytemuck::Zeroable;
use fastrand::Rng;
use shatter_export::{glb_bytes, mjcf};
use shatter_proto::layout::{Layout, SectionCounts, SectionsMut};
use shatter_proto::result::{
    AlignedBlock, BondWire, FragmentWire, HullWire, NO_MATERIAL, OUTER, OuterAttributes, RunWire, SkinVertex, SkinWire,
};
use shatter_proto::view::CheckedLayout;

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Arrays of one fragment, a tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    /// Faces that are outer; the others are cracks, one run each. `None`: it has no faces at all.
    outer: Option<usize>,
    hull: bool,
}

/// The sections of a result.
#[derive(Default)]
struct Made {
    fragments: Vec<FragmentWire>,
    runs: Vec<RunWire>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    bonds: Vec<BondWire>,
    hulls: Vec<HullWire>,
    hull_positions: Vec<[f32; 3]>,
    hull_indices: Vec<u32>,
    outer_attributes: Vec<OuterAttributes>,
    materials: Vec<u32>,
    skins: Vec<SkinWire>,
    skin_vertices: Vec<SkinVertex>,
    skin_indices: Vec<u32>,
    skin_materials: Vec<u32>,
    outer_uvs2: Vec<[f32; 2]>,
    outer_colors: Vec<[u8; 4]>,
    skin_uvs2: Vec<[f32; 2]>,
    skin_colors: Vec<[u8; 4]>,
}

/// Which effects ran.
#[derive(Clone, Copy, Debug, Default)]
struct Ran {
    normals: bool,
    uv: bool,
    bonds: bool,
    hulls: bool,
    attributes: bool,
    skin: bool,
    materials: bool,
    /// Second texture coordinates and colors.
    colors: bool,
}

impl Made {
    fn new(shapes: &[Shape], ran: Ran) -> Self {
        let mut made = Self::default();
        for shape in shapes {
            made.push(*shape, ran);
        }
        if ran.bonds && shapes.len() > 1 {
            made.bonds.push(BondWire { fragments: [0, 1], area_m2: 1.0, ..BondWire::zeroed() });
        }
        made
    }

    fn push(&mut self, shape: Shape, ran: Ran) {
        let id = self.fragments.len() as u32;
        let (vertex_first, index_first) = (self.positions.len() as u32, self.indices.len() as u32);
        let run_first = self.runs.len() as u32;
        if let Some(outer) = shape.outer {
            let (outer, cracks) = FACES.split_at(outer);
            let runs = [(false, outer)].into_iter().chain(cracks.chunks(1).map(|face| (true, face)));
            runs.filter(|(_, faces)| !faces.is_empty()).for_each(|(crack, faces)| self.run(id, crack, faces, ran));
        }
        self.fragments.push(FragmentWire {
            id,
            vertex_first,
            vertex_count: self.positions.len() as u32 - vertex_first,
            index_first,
            index_count: self.indices.len() as u32 - index_first,
            run_first,
            run_count: self.runs.len() as u32 - run_first,
            volume_m3: 1.0 / 6.0,
            mass_kg: 1.0,
            inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            ..FragmentWire::zeroed()
        });
        if ran.hulls {
            self.hull(shape.hull);
        }
        if ran.skin {
            self.skin(shape.outer.unwrap_or(0), ran);
        }
    }

    fn run(&mut self, fragment: u32, crack: bool, faces: &[[usize; 3]], ran: Ran) {
        let first = self.fragments.last().map_or(0, |last| last.vertex_first + last.vertex_count);
        let (vertex_first, index_first) = (self.positions.len() as u32, self.indices.len() as u32);
        for corner in faces.iter().flatten() {
            self.indices.push(self.positions.len() as u32 - first);
            self.positions.push(CORNERS[*corner]);
            if ran.normals {
                self.normals.push([0.0, 1.0, 0.0]);
            }
            if ran.uv {
                self.uvs.push([0.25, 0.5]);
            }
            if ran.attributes {
                let normal = if crack { [0.0; 3] } else { [0.0, 1.0, 0.0] };
                self.outer_attributes.push(OuterAttributes { normal, uv: [0.5; 2] });
            }
            if ran.attributes && ran.colors {
                self.outer_uvs2.push([0.75; 2]);
                self.outer_colors.push([1, 2, 3, 4]);
            }
        }
        if ran.attributes && ran.materials {
            self.materials.extend(faces.iter().map(|_| if crack { NO_MATERIAL } else { 0 }));
        }
        self.runs.push(RunWire {
            fragment,
            neighbor: OUTER,
            vertex_first,
            vertex_count: self.positions.len() as u32 - vertex_first,
            index_first,
            index_count: self.indices.len() as u32 - index_first,
            material: u32::from(crack),
            reserved: 0,
        });
    }

    fn hull(&mut self, is_there: bool) {
        let (vertex_first, index_first) = (self.hull_positions.len() as u32, self.hull_indices.len() as u32);
        if is_there {
            self.hull_positions.extend(CORNERS);
            self.hull_indices.extend(FACES.iter().flatten().map(|corner| *corner as u32));
        }
        self.hulls.push(HullWire {
            vertex_first,
            vertex_count: self.hull_positions.len() as u32 - vertex_first,
            index_first,
            index_count: self.hull_indices.len() as u32 - index_first,
            coverage: 1.0,
            margin_m: 0.0,
        });
    }

    /// A skin a little beside the outer faces.
    fn skin(&mut self, outer: usize, ran: Ran) {
        let (vertex_first, index_first) = (self.skin_vertices.len() as u32, self.skin_indices.len() as u32);
        for (place, corner) in FACES[..outer].iter().flatten().enumerate() {
            self.skin_vertices.push(SkinVertex {
                position_m: CORNERS[*corner].map(|x| 1.01 * x),
                normal: [0.0, 1.0, 0.0],
                uv: if ran.materials { [0.1; 2] } else { [0.0; 2] },
            });
            self.skin_indices.push(place as u32);
            if ran.colors {
                self.skin_uvs2.push([0.25; 2]);
                self.skin_colors.push([5, 6, 7, 8]);
            }
        }
        if ran.materials {
            self.skin_materials.extend(std::iter::repeat_n(0, outer));
        }
        self.skins.push(SkinWire {
            vertex_first,
            vertex_count: self.skin_vertices.len() as u32 - vertex_first,
            index_first,
            index_count: self.skin_indices.len() as u32 - index_first,
        });
    }

    /// The bytes that a daemon would send, and what checked them.
    fn sent(&self) -> (Vec<AlignedBlock>, CheckedLayout) {
        let counts = SectionCounts {
            fragments: self.fragments.len(),
            runs: self.runs.len(),
            vertices: self.positions.len(),
            indices: self.indices.len(),
            normals: self.normals.len(),
            uvs: self.uvs.len(),
            bonds: self.bonds.len(),
            hulls: self.hulls.len(),
            hull_vertices: self.hull_positions.len(),
            hull_indices: self.hull_indices.len(),
            outer_attributes: self.outer_attributes.len(),
            materials: self.materials.len(),
            skins: self.skins.len(),
            skin_vertices: self.skin_vertices.len(),
            skin_indices: self.skin_indices.len(),
            skin_materials: self.skin_materials.len(),
            outer_uvs2: self.outer_uvs2.len(),
            outer_colors: self.outer_colors.len(),
            skin_uvs2: self.skin_uvs2.len(),
            skin_colors: self.skin_colors.len(),
            ..SectionCounts::default()
        };
        let layout = Layout::new(&counts).unwrap();
        let mut payload = vec![AlignedBlock::zeroed(); layout.blocks()];
        self.fill(layout.split(&mut payload).unwrap());
        let checked = CheckedLayout::new(&layout.header(1), &payload).unwrap();
        (payload, checked)
    }

    fn fill(&self, sections: SectionsMut<'_>) {
        sections.fragments.copy_from_slice(&self.fragments);
        sections.runs.copy_from_slice(&self.runs);
        sections.positions.copy_from_slice(&self.positions);
        sections.indices.copy_from_slice(&self.indices);
        sections.normals.copy_from_slice(&self.normals);
        sections.uvs.copy_from_slice(&self.uvs);
        sections.bonds.copy_from_slice(&self.bonds);
        sections.hulls.copy_from_slice(&self.hulls);
        sections.hull_positions.copy_from_slice(&self.hull_positions);
        sections.hull_indices.copy_from_slice(&self.hull_indices);
        sections.outer_attributes.copy_from_slice(&self.outer_attributes);
        sections.materials.copy_from_slice(&self.materials);
        sections.skins.copy_from_slice(&self.skins);
        sections.skin_vertices.copy_from_slice(&self.skin_vertices);
        sections.skin_indices.copy_from_slice(&self.skin_indices);
        sections.skin_materials.copy_from_slice(&self.skin_materials);
        sections.outer_uvs2.copy_from_slice(&self.outer_uvs2);
        sections.outer_colors.copy_from_slice(&self.outer_colors);
        sections.skin_uvs2.copy_from_slice(&self.skin_uvs2);
        sections.skin_colors.copy_from_slice(&self.skin_colors);
    }
}

/// Reads every accessor of a fragment.
fn read(fragment: &Fragment<'_>) -> usize {
    let hull = fragment.hull().map_or(0, |hull| hull.positions.len() + hull.indices.len());
    let skin = fragment.skin().map_or(0, |skin| skin.vertices.len() + skin.indices.len() + skin.materials.len());
    let runs: usize = fragment.runs().map(|run| run.positions.len() + run.indices.len()).sum();
    let optional = fragment.outer_uvs2().len() + fragment.outer_colors().len();
    let own = optional
        + fragment.positions().len()
        + fragment.normals().len()
        + fragment.uvs().len()
        + fragment.outer_attributes().len();
    own + hull + skin + runs + fragment.materials().len() + usize::from(fragment.is_closed())
}

fn check(shapes: &[Shape], ran: Ran) {
    let (payload, checked) = Made::new(shapes, ran).sent();
    let view = checked.view(&payload).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    assert!(fragments(view).map(|fragment| read(&fragment)).sum::<usize>() > 0 || view.positions.is_empty());
    let solid = shapes.iter().all(|shape| shape.outer.is_some());
    let shown = format!("{shapes:?} {ran:?}");
    assert_eq!(with_views(view, |views| glb_bytes(views).is_ok()), solid, "{shown}");
    assert_eq!(with_object(view, |object| mjcf(object, "meshes").is_ok()), solid, "{shown}");
    assert_eq!(with_object(view, |object| write_obj(&file("obj"), object).is_ok()), solid, "{shown}");
    let hulls = ran.hulls && shapes.iter().any(|shape| shape.hull);
    assert_eq!(hulls_glb(view, &file("hulls.glb")).is_ok(), hulls, "{shown}");
    let seen = shapes.iter().filter(|shape| shape.outer.is_some()).count();
    let written = with_skins(view, |views| write_glb(&file("skins.glb"), views));
    match ran.skin && seen > 0 {
        true => assert_eq!(written.unwrap().fragments, seen, "{shown}"),
        false => assert!(matches!(written, Err(ExportError::NoFragments)), "{shown}"),
    }
}

#[test]
fn results_with_missing_sections_do_not_panic() {
    let mut random = Rng::with_seed(22);
    for round in 0..300 {
        let mut shape = || {
            let outer = Some(random.usize(..=FACES.len())).filter(|_| round % 3 > 0 || random.bool());
            Shape { outer, hull: random.bool() }
        };
        let shapes: Vec<Shape> = (0..=round % 4).map(|_| shape()).collect();
        let bits: [bool; 8] = std::array::from_fn(|_| random.bool());
        let [normals, uv, bonds, hulls, attributes, skin, materials, colors] = bits;
        check(&shapes, Ran { normals, uv, bonds, hulls, attributes, skin, materials, colors });
    }
}

/// The materials of fragments and skins are those of the result, and the errors of a file of materials name it.
#[test]
fn materials_of_fragments_and_skins_are_written_with_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, file) = (folder.path().join("mesh.gltf"), folder.path().join("a.glb"));
    let write = |count: usize, materials: bool, has_skin: bool| {
        let list = vec![r#"{"name":"glaze"}"#; count].join(",");
        std::fs::write(&mesh, format!(r#"{{"asset":{{"version":"2.0"}},"materials":[{list}]}}"#)).unwrap();
        let source = read_materials(&mesh).unwrap();
        let ran = Ran { attributes: true, skin: true, materials, ..Ran::default() };
        let shapes = [0, 2].map(|outer| Shape { outer: Some(outer), hull: false });
        let (payload, checked) = Made::new(&shapes, ran).sent();
        let view = checked.view(&payload).unwrap();
        let write = |views: &[FragmentView<'_>]| write_glb_with(&file, views, &source);
        let written = if has_skin { with_skins(view, write) } else { with_views(view, write) };
        written.map_err(|error| failed(&file, &error))
    };
    for has_skin in [false, true] {
        assert_eq!(write(1, true, has_skin).unwrap().fragments, 2);
        let text = String::from_utf8_lossy(&std::fs::read(&file).unwrap()).into_owned();
        assert!(text.contains("glaze") && !text.contains(r#""outer""#), "{text}");
        let error = write(1, false, has_skin).unwrap_err();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Effect, "attributes"));
    }
    assert!(write(0, true, false).unwrap_err().message.contains("has none"));
    let error = read_materials(&folder.path().join("none.glb")).unwrap_err();
    assert!(error.kind == ErrorKind::Output && error.at.ends_with("none.glb"), "{error}");
}

/// The defect that was found: a fragment that lies wholly inside, with a skin and without `uv`.
#[test]
fn an_interior_fragment_is_written_with_the_skins() {
    let [inside, outside] = [0, 2].map(|outer| Shape { outer: Some(outer), hull: false });
    let ran = Ran { skin: true, ..Ran::default() };
    check(&[inside, outside], ran);
}

/// Second texture coordinates and colors reach the views of fragments, and those of skins, whose cracks are white.
#[test]
fn second_textures_and_colors_are_handed_on() {
    let shapes = [Shape { outer: Some(2), hull: false }];
    let ran = Ran { attributes: true, skin: true, colors: true, ..Ran::default() };
    let (payload, checked) = Made::new(&shapes, ran).sent();
    let view = checked.view(&payload).unwrap();
    with_views(view, |views| {
        assert_eq!((views[0].uvs2, views[0].colors), (&[[0.75; 2]; 12][..], &[[1, 2, 3, 4]; 12][..]));
    });
    with_skins(view, |views| {
        let outer = ([[0.25; 2]; 6], [[5, 6, 7, 8]; 6]);
        assert_eq!((&views[0].uvs2[..6], &views[0].colors[..6]), (&outer.0[..], &outer.1[..]));
        assert!(views[0].positions.len() == views[0].uvs2.len() && views[0].colors.len() == views[0].uvs2.len());
        assert!(
            views[0].uvs2[6..].iter().all(|uv| *uv == [0.0; 2])
                && views[0].colors[6..].iter().all(|own| *own == [255; 4])
        );
    });
}
