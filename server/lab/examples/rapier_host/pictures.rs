//! Contact sheet of the film, drawn by the lab's rasterizer.

use super::Failure;
use super::film::{Actor, Film, Key, Look};
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use shatter_lab::picture::{
    Backdrop, CREASE_DEG, Camera, Color, DrawnMesh, Image, PictureSize, Projection, RenderStyle, crack_color, draw,
    fragment_color,
};

const COLUMNS: usize = 4;
const ROWS: usize = 3;
const SIZE: PictureSize = PictureSize { width: 560, height: 360 };

/// Corners of the visible volume, m.
const SEEN_M: [[f32; 3]; 2] = [[-1.9, 0.0, -1.2], [1.9, 1.9, 1.2]];
/// Margin of the drawn volume around the visible one, m.
const BESIDE_M: f32 = 1.2;
/// Direction to the camera.
const FROM: [f32; 3] = [0.30, 0.42, 1.0];

/// PNG of twelve pictures, row by row.
pub fn sheet(film: &Film, seconds: f64) -> Result<Vec<u8>, Failure> {
    let count = COLUMNS * ROWS;
    let painted: Vec<DrawnMesh> = film.actors.iter().map(paint).collect();
    let corners: Vec<Point3<f32>> =
        (0..8).map(|k| Point3::from([0, 1, 2].map(|axis| SEEN_M[k >> axis & 1][axis]))).collect();
    let lens = Projection::Perspective { fov_deg: 26.0 };
    let camera = Camera::fit(&corners, Vector3::from(FROM), lens, SIZE.width as f32 / SIZE.height as f32);
    let backdrop = Backdrop::Gradient(Color::oklch(0.93, 0.01, 250.0), Color::oklch(0.80, 0.015, 90.0));
    let picture = |k: usize| {
        let at_s = seconds * (k as f64 + 0.999) / count as f64;
        let mut scene = DrawnMesh::default();
        for (actor, mesh) in film.actors.iter().zip(&painted).filter(|(actor, _)| !is_floor(actor)) {
            actor.at(at_s).into_iter().filter(|key| is_near(key)).for_each(|key| scene.append(moved(mesh, key)));
        }
        draw(&scene, &camera, SIZE, RenderStyle::STUDIO, Some(0.0), backdrop)
    };
    let rows: Vec<Image> = (0..ROWS)
        .map(|row| Image::beside(&(0..COLUMNS).map(|column| picture(row * COLUMNS + column)).collect::<Vec<_>>()))
        .collect();
    let size = PictureSize { width: COLUMNS * SIZE.width, height: ROWS * SIZE.height };
    Ok(Image { size, pixels: rows.into_iter().flat_map(|row| row.pixels).collect() }.png()?)
}

/// Whether an actor is near. Distant ones are not visible, and would coarsen the shadows, whose maps span the whole scene.
fn is_near(key: &Key) -> bool {
    let [low, high] = SEEN_M;
    (0..3).all(|axis| (low[axis] - BESIDE_M..high[axis] + BESIDE_M).contains(&key.place_m[axis]))
}

/// Whether an actor is the floor, which is the ground of the picture.
pub fn is_floor(actor: &Actor) -> bool {
    actor.look == Look::Ground && actor.keys.iter().all(|key| key.place_m[1] < 0.0)
}

/// Mesh of an actor about its center.
pub fn paint(actor: &Actor) -> DrawnMesh {
    let (outer, crack) = match actor.look {
        Look::Piece(number) => (fragment_color(number), crack_color(number)),
        Look::Steel => [Color::oklch(0.45, 0.01, 250.0); 2].into(),
        Look::Ground => [Color::oklch(0.72, 0.03, 70.0); 2].into(),
    };
    let shell = &actor.shell;
    let positions = shell.positions.iter().map(|&point| Point3::from(point)).collect();
    let triangles: Vec<[u32; 3]> = shell.outer.iter().chain(&shell.cracks).copied().collect();
    let first_crack = shell.outer.len();
    let color = |triangle, _| if triangle < first_crack { outer } else { crack };
    let mut mesh = DrawnMesh::paint(positions, triangles, CREASE_DEG, color);
    let vertices = mesh.triangles.as_flattened().iter().zip(mesh.corners.as_flattened_mut());
    for (vertex, corner) in vertices.filter(|_| !shell.normals.is_empty()) {
        corner.normal = Vector3::from(shell.normals[*vertex as usize]);
    }
    mesh
}

pub fn moved(mesh: &DrawnMesh, key: &Key) -> DrawnMesh {
    let [x, y, z, w] = key.turn;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let mut mesh = mesh.clone();
    mesh.positions.iter_mut().for_each(|point| *point = turn * *point + Vector3::from(key.place_m));
    mesh.corners.as_flattened_mut().iter_mut().for_each(|corner| corner.normal = turn * corner.normal);
    mesh
}
