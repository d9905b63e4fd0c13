//! Exported files against an independent reader.

use proptest::prelude::*;
use shatter_export::{ExportError, FragmentView, RunView, glb_bytes};
use shatter_fracture::surface::{self, LengthUnit, UpAxis};
use shatter_tests::glb;

/// Positions, indices, runs and merges of a fragment.
type Parts = (Vec<[f32; 3]>, Vec<u32>, Vec<RunView>, Vec<[u32; 2]>);

/// A box cut across at `cut` of its length: outer faces first, then the crack, with vertices of their own.
fn halves(cut: f32) -> [Parts; 2] {
    [(0.0, cut, [4, 6, 7, 5]), (cut, 1.0, [0, 1, 3, 2])].map(|(low, high, open)| {
        let corner = |k: u32| [if k & 4 == 0 { low } else { high }, (k >> 1 & 1) as f32, (k & 1) as f32];
        let mut positions: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let two = |[a, b, c, d]: [u32; 4]| [a, b, c, a, c, d];
        let outer: Vec<u32> = sides.into_iter().filter(|side| *side != open).flat_map(two).collect();
        positions.extend(open.map(corner));
        let runs = vec![
            RunView { crack: false, index_first: 0, index_count: 30 },
            RunView { crack: true, index_first: 30, index_count: 6 },
        ];
        let merges = (0..4).map(|k| [8 + k, open[k as usize]]).collect();
        (positions, [outer, two([8, 9, 10, 11]).to_vec()].concat(), runs, merges)
    })
}

/// The file of a box whose first half has its center at `place_m`.
fn file(cut: f32, place_m: [f64; 3]) -> Result<Vec<u8>, ExportError> {
    let halves = halves(cut);
    let views: Vec<FragmentView<'_>> = halves
        .iter()
        .enumerate()
        .map(|(id, (positions, indices, runs, merges))| FragmentView {
            normals: &[],
            uvs: &[],
            uvs2: &[],
            colors: &[],
            materials: &[],
            id: id as u32,
            body: 0,
            positions,
            indices,
            runs,
            merges,
            center_m: [place_m[0] + id as f64, place_m[1], place_m[2]],
            volume_m3: if id == 0 { f64::from(cut) } else { 1.0 - f64::from(cut) },
            mass_kg: 2.0,
            inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
        })
        .collect();
    Ok(glb_bytes(&views)?.0)
}

/// Checks that both halves are closed, have their runs, and hold the stated values.
fn check(cut: f32) {
    let fragments = glb::parse(&file(cut, [0.0; 3]).unwrap()).unwrap();
    assert_eq!(fragments.len(), 2);
    for fragment in &fragments {
        fragment.check_closed().unwrap();
        assert!(fragment.manifold.is_some());
        assert_eq!((fragment.outer.len(), fragment.crack.len()), (10, 2));
        assert!((fragment.volume_m3() - fragment.stated_volume_m3).abs() < 1e-7);
    }
    assert_eq!(fragments[1].center_m, [1.0, 0.0, 0.0]);
}

proptest! {
    #[test]
    fn an_independent_reader_finds_both_halves_closed(cut in 0.001f32..0.999) {
        check(cut);
    }
}

#[test]
fn halves_far_from_the_origin_are_read_in_their_places() {
    let place_m = [500_000.3, 200.1, 5_000_000.7];
    let bytes = file(0.5, place_m).unwrap();
    let fragments = glb::parse(&bytes).unwrap();
    for (id, fragment) in fragments.iter().enumerate() {
        let wanted = [place_m[0] + id as f64, place_m[1], place_m[2]];
        let off = [0, 1, 2].map(|k| (fragment.center_m[k] - wanted[k]).abs());
        assert!(off.iter().all(|off| *off < 1e-7), "{:?} is read, {wanted:?} was written", fragment.center_m);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("far.glb");
    std::fs::write(&path, bytes).unwrap();
    let mesh = surface::read(&path, LengthUnit::M, UpAxis::Y).unwrap();
    let low = mesh.positions_m.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    assert!((low - place_m[2]).abs() < 1e-7, "{low}");
}

#[test]
fn the_reader_tells_an_open_fragment_from_a_closed_one() {
    let mut fragments = glb::parse(&file(0.5, [0.0; 3]).unwrap()).unwrap();
    fragments[0].positions[9][1] += 1e-6;
    assert!(fragments[0].check_closed().is_err());
    fragments[1].crack.pop();
    assert!(fragments[1].check_closed().is_err());
}

/// Normals, texture coordinates and materials are read as they were written; if one fragment lacks them, all do.
#[test]
fn attributes_round_trip_through_glb() {
    let halves = halves(0.25);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let read_halves = |textured: [bool; 2]| {
        let uvs =
            halves.each_ref().map(|(positions, ..)| positions.iter().map(|[x, y, z]| [x + y, *z]).collect::<Vec<_>>());
        let normals = halves.each_ref().map(|(positions, ..)| vec![[0.0f32, 0.6, -0.8]; positions.len()]);
        let view = |id: usize| {
            let (positions, indices, runs, merges) = &halves[id];
            let uvs: &[[f32; 2]] = if textured[id] { &uvs[id] } else { &[] };
            let (center_m, volume_m3, mass_kg) = ([0.0; 3], 1.0, 1.0);
            let normals = &normals[id];
            FragmentView {
                id: id as u32,
                body: 0,
                positions,
                normals,
                uvs,
                uvs2: &[],
                colors: &[],
                materials: &[],
                indices,
                runs,
                merges,
                center_m,
                volume_m3,
                mass_kg,
                inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            }
        };
        std::fs::write(&path, glb_bytes(&[view(0), view(1)]).unwrap().0).unwrap();
        surface::read(&path, LengthUnit::M, UpAxis::Y).unwrap()
    };
    let mesh = read_halves([true, true]);
    assert_eq!(
        (mesh.attributes.names.clone(), mesh.attributes.lost.len()),
        (vec!["outer".to_owned(), "crack".to_owned()], 0)
    );
    assert_eq!(
        [0, 1].map(|material| mesh.attributes.materials.iter().filter(|own| **own == material).count()),
        [20, 4]
    );
    assert_eq!((mesh.attributes.normals.len(), mesh.attributes.uvs.len(), mesh.triangles.len()), (24, 24, 24));
    for (triangle, uvs) in mesh.triangles.iter().zip(&mesh.attributes.uvs) {
        for (vertex, uv) in triangle.iter().zip(uvs) {
            let at = mesh.positions_m[*vertex as usize].map(|x| x as f32);
            assert_eq!(*uv, [at.x + at.y, at.z]);
        }
    }
    let apart = |normal: &[f32; 3]| (normal[0].abs() + (normal[1] - 0.6).abs() + (normal[2] + 0.8).abs()) > 1e-6;
    assert!(!mesh.attributes.normals.iter().flatten().any(apart));
    assert!(read_halves([false, false]).attributes.lost.is_empty());
    let half = read_halves([true, false]).attributes;
    assert!(half.uvs.is_empty() && half.normals.len() == 24, "{:?}", half.lost);
    assert_eq!(half.lost, [("texture coordinates", 12)]);
}
