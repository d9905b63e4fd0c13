//! Visualization of the effects that add data to a result.

use super::result::GalleryResult;
use crate::picture::{Color, DrawnCorner, DrawnMesh, arrow, fragment_color};
use nalgebra::{Point3, Vector3};

/// Displacement of fragments over their distance from the center.
pub const SPREAD: f64 = 0.35;

/// The same for pictures of bonds.
pub const BOND_SPREAD: f64 = 1.1;

/// Size of checkerboard fields that show texture coordinates, m.
const FIELD_M: f32 = 0.012;

/// Size of checkerboard fields on outer faces, m.
const TILE_M: f32 = 0.04;

/// Magnification of debris chips.
const CHIP: f32 = 3.0;

/// Distance that the fastest fragment flies before the picture is taken, over the object's size.
const FLIGHT: f32 = 0.35;

/// Bonds as rods between their fragments.
pub fn bonds(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = result.mesh(BOND_SPREAD);
    let bonds = result.pieces.bonds();
    let most = bonds.iter().map(|bond| bond.area_m2).fold(f64::MIN_POSITIVE, f64::max);
    for bond in &bonds {
        let [from, to] = bond.fragments.map(|fragment| result.offset(fragment, BOND_SPREAD));
        let thickness = ((bond.area_m2 / most).sqrt() * 0.05).max(0.01) as f32;
        mesh.append(rod(from.into(), to.into(), thickness * (to - from).norm(), Color::oklch(0.45, 0.16, 28.0)));
    }
    mesh
}

/// Debris as chips of their size.
pub fn debris(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    for chip in result.pieces.debris() {
        let place = result.offset(chip.fragment, SPREAD) + chip.position_m.cast::<f32>();
        let normal: Vector3<f32> = chip.normal.cast();
        let size = CHIP * chip.size_m as f32;
        let tip = Point3::from(place + normal * (1.5 * size));
        mesh.append(arrow(tip, -normal, size, Color::oklch(0.75, 0.19, 60.0)));
    }
    mesh
}

/// Fragments; those smaller than `least_m3` in red, the others pale.
pub fn slivers(result: &GalleryResult, least_m3: f64) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    let [small, large] = [Color::oklch(0.55, 0.22, 28.0), Color::oklch(0.9, 0.01, 90.0)];
    let mut is_small = vec![false; mesh.positions.len()];
    for row in result.pieces.fragments.iter().filter(|row| row.volume_m3 < least_m3) {
        is_small[row.vertex_first as usize..(row.vertex_first + row.vertex_count) as usize].fill(true);
    }
    for (corners, triangle) in mesh.corners.iter_mut().zip(&mesh.triangles) {
        let color = if is_small[triangle[0] as usize] { small } else { large };
        corners.iter_mut().for_each(|corner| corner.color = color);
    }
    mesh
}

/// Fragments, and the clamp if `holds`.
pub fn held(result: &GalleryResult, [low, high]: [Point3<f64>; 2], holds: bool) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    if holds {
        let clamp = shatter_fracture::surface::shapes::cuboid((high - low).into());
        // Behind the end of the bar, which moves apart with its fragments.
        let middle = nalgebra::center(&low, &high) - Vector3::x() * (1.2 * (high.x - low.x));
        let positions = clamp.positions_m.iter().map(|corner| result.point(&(middle + corner.coords))).collect();
        mesh.append(DrawnMesh::paint(positions, clamp.triangles, 1.0, |_, _| Color::oklch(0.35, 0.02, 250.0)));
    }
    mesh
}

/// Convex hulls in the places of the fragments.
pub fn hulls(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = DrawnMesh::default();
    let hulls = &result.pieces.hulls;
    for (fragment, row) in hulls.rows.iter().enumerate() {
        let own = &hulls.positions[row.vertex_first as usize..][..row.vertex_count as usize];
        let indices = &hulls.indices[row.index_first as usize..][..row.index_count as usize];
        let positions = own.iter().map(|&position| Point3::from(position)).collect();
        let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let color = fragment_color(fragment as u32);
        mesh.append(
            DrawnMesh::paint(positions, triangles, 1.0, |_, _| color).moved(result.offset(fragment as u32, SPREAD)),
        );
    }
    mesh
}

/// Fragments a moment after release, moved by their release velocities.
pub fn release(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = result.mesh(0.0);
    let fastest = result.pieces.velocities.iter().map(|own| own.linear_m_s.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = mesh.bounds();
    let time = FLIGHT * (high - low).norm() / fastest as f32;
    for (row, velocity) in result.pieces.fragments.iter().zip(&result.pieces.velocities) {
        let flight: Vector3<f32> = velocity.linear_m_s.cast::<f32>() * time;
        let turn = nalgebra::Rotation3::new(velocity.angular_rad_s.cast::<f32>() * time);
        let center = result.offset(row.id, 0.0);
        let own = row.vertex_first as usize..(row.vertex_first + row.vertex_count) as usize;
        for position in &mut mesh.positions[own] {
            *position = Point3::from(turn * (position.coords - center) + center + flight);
        }
    }
    mesh
}

/// Fragments lit by the normals of the result, or by those of flat triangles.
pub fn normals(result: &GalleryResult, smooth: bool) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    let mut own = vec![[0.0; 3]; result.pieces.counts.vertices];
    result.pieces.normals(&mut own);
    let flat = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::y)
    };
    let flats: Vec<Vector3<f32>> = mesh.triangles.iter().map(flat).collect();
    for ((corners, triangle), flat) in mesh.corners.iter_mut().zip(&mesh.triangles).zip(flats) {
        for (corner, vertex) in corners.iter_mut().zip(triangle) {
            corner.normal = if smooth { Vector3::from(own[*vertex as usize]) } else { flat };
        }
    }
    mesh
}

/// Crack faces with a checkerboard in their texture coordinates.
pub fn uvs(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    let mut own = vec![[0.0; 2]; result.pieces.counts.vertices];
    result.pieces.uvs(&mut own);
    let at = |triangle: &[u32; 3]| triangle.map(|vertex| own[vertex as usize]);
    let has_own = |uvs: &[[f32; 2]; 3]| uvs.iter().any(|uv| *uv != [0.0; 2]);
    mesh.checkers =
        mesh.triangles.iter().map(|own| Some(at(own)).filter(has_own).map(|uvs| board(uvs, FIELD_M))).collect();
    mesh
}

/// Texture coordinates in fields of size `field`.
fn board(uvs: [[f32; 2]; 3], field: f32) -> [[f32; 2]; 3] {
    uvs.map(|uv| uv.map(|x| x / field))
}

/// Outer faces with a checkerboard in the input's texture coordinates, lit by its normals.
pub fn attributes(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    let attributes = &result.pieces.attributes.vertices;
    for (corners, triangle) in mesh.corners.iter_mut().zip(&mesh.triangles) {
        let own = triangle.map(|vertex| &attributes[vertex as usize]);
        let is_crack = own.iter().any(|look| look.normal == [0.0; 3]);
        mesh.checkers.push((!is_crack).then(|| board(own.map(|look| look.uv), TILE_M)));
        for (corner, look) in corners.iter_mut().zip(own).filter(|_| !is_crack) {
            corner.normal = look.normal.into();
        }
    }
    mesh
}

/// Crack faces, and the input's own triangles with a checkerboard in their texture coordinates.
pub fn skin(result: &GalleryResult) -> DrawnMesh {
    let mut mesh = result.mesh(SPREAD);
    let mut is_crack = vec![false; mesh.positions.len()];
    for run in result.pieces.runs.iter().filter(|run| run.crack) {
        is_crack[run.vertex_first as usize..(run.vertex_first + run.vertex_count) as usize].fill(true);
    }
    let cracks: Vec<bool> = mesh.triangles.iter().map(|triangle| is_crack[triangle[0] as usize]).collect();
    let mut kept = cracks.iter();
    mesh.corners.retain(|_| kept.next().is_some_and(|kept| *kept));
    mesh.triangles.retain(|triangle| is_crack[triangle[0] as usize]);
    let skins = &result.pieces.skins;
    for (fragment, row) in skins.rows.iter().enumerate() {
        let own = &skins.vertices[row.vertex_first as usize..][..row.vertex_count as usize];
        let indices = &skins.indices[row.index_first as usize..][..row.index_count as usize];
        let triangles: Vec<[u32; 3]> = indices.as_chunks::<3>().0.to_vec();
        let color = fragment_color(fragment as u32);
        let corner = |vertex: u32| DrawnCorner { normal: own[vertex as usize].normal.into(), color };
        let corners = triangles.iter().map(|triangle| triangle.map(corner)).collect();
        let uvs = |triangle: &[u32; 3]| triangle.map(|vertex| own[vertex as usize].uv);
        let checkers = triangles.iter().map(|triangle| Some(board(uvs(triangle), TILE_M))).collect();
        let positions = own.iter().map(|vertex| Point3::from(vertex.position_m)).collect();
        let skin = DrawnMesh { positions, triangles, corners, checkers };
        mesh.append(skin.moved(result.offset(fragment as u32, SPREAD)));
    }
    mesh
}

/// Sphere of triangles that marks a point or a region.
pub fn ball(center: Point3<f32>, radius: f32, color: Color) -> DrawnMesh {
    let mesh = shatter_fracture::surface::shapes::sphere(f64::from(radius), 2);
    let positions = mesh.positions_m.iter().map(|point| center + point.coords.cast::<f32>()).collect();
    DrawnMesh::paint(positions, mesh.triangles, 60.0, |_, _| color)
}

/// Rod with six sides.
fn rod(from: Point3<f32>, to: Point3<f32>, radius: f32, color: Color) -> DrawnMesh {
    let Some(axis) = (to - from).try_normalize(1e-12) else { return DrawnMesh::default() };
    let aside = if axis.y.abs() > 0.9 { Vector3::x() } else { Vector3::y() };
    let across = aside.cross(&axis).normalize();
    let along = axis.cross(&across);
    let side = |k: u32| {
        let (sine, cosine) = (std::f32::consts::TAU * k as f32 / 6.0).sin_cos();
        (across * cosine + along * sine) * radius
    };
    let positions = (0..6).flat_map(|k| [from + side(k), to + side(k)]).collect();
    let faces = |k: u32| {
        let [a, b, c, d] = [2 * k, 2 * k + 1, 2 * ((k + 1) % 6), 2 * ((k + 1) % 6) + 1];
        [[a, c, b], [c, d, b]]
    };
    DrawnMesh::paint(positions, (0..6).flat_map(faces).collect(), 80.0, |_, _| color)
}
