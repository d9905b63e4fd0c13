//! Pictures of the painted vase: one in full size, and an animation in slow motion.

use super::Failure;
use super::film::{Actor, Film, Look};
use super::glaze;
use super::pictures::{is_floor, moved, paint};
use nalgebra::{Point3, Vector3};
use shatter_lab::picture::{
    AnimationFrame, Backdrop, Camera, Color, DrawnMesh, Finish, Image, PictureSize, Projection, RenderStyle,
    animated_png, draw_textured,
};

const STILL: PictureSize = PictureSize { width: 1200, height: 800 };
const FRAME: PictureSize = PictureSize { width: 440, height: 293 };

/// Time of the large picture after the break, s.
const STILL_S: f64 = 0.08;

/// Times of the first frame, before the break, and between frames, s; number of frames.
const LEAD_S: f64 = 0.06;
const STEP_S: f64 = 1.0 / 240.0;
const FRAMES: u32 = 76;

/// Time for which a frame is shown, and the last one, ms. So the animation is twelve times slower than the simulation.
const DELAY_MS: u16 = 50;
const LAST_MS: u16 = 600;

/// Corners of the visible volume, m.
const SEEN_M: [[f32; 3]; 2] = [[-0.11, 0.0, -0.10], [0.29, 0.35, 0.10]];
/// Margin of the drawn volume around the visible one, m.
const BESIDE_M: f32 = 0.25;
/// Direction to the camera.
const FROM: [f32; 3] = [-0.40, 0.34, 1.0];

const STYLE: RenderStyle = RenderStyle { key: 0.83, fill: 0.14, sky: 0.52, bounce: 0.24, gloss: 0.0 };

/// PNG of the fragments shortly after the break, and an animated PNG of the impact.
pub fn pictures(film: &Film) -> Result<[Vec<u8>; 2], Failure> {
    let actors: Vec<(&Actor, DrawnMesh)> =
        film.actors.iter().filter(|actor| !is_floor(actor)).map(|actor| (actor, paint(actor))).collect();
    let break_s = break_s(film);
    let still = picture(&actors, break_s + STILL_S, STILL).png()?;
    let frame = |k: u32| AnimationFrame {
        image: picture(&actors, break_s - LEAD_S + STEP_S * f64::from(k), FRAME),
        delay_ms: if k + 1 < FRAMES { DELAY_MS } else { LAST_MS },
    };
    let frames: Vec<AnimationFrame> = (0..FRAMES).map(frame).collect();
    Ok([still, animated_png(&frames)?])
}

/// Time of the first break; the begin of the film if nothing breaks.
fn break_s(film: &Film) -> f64 {
    film.actors.iter().filter_map(|actor| actor.gone_s).min_by(f64::total_cmp).unwrap_or_default()
}

fn picture(actors: &[(&Actor, DrawnMesh)], at_s: f64, size: PictureSize) -> Image {
    let corner = |k: usize, margin: f32| {
        Point3::from(
            [0, 1, 2].map(|axis| SEEN_M[k >> axis & 1][axis] + if k >> axis & 1 == 1 { margin } else { -margin }),
        )
    };
    let seen: Vec<Point3<f32>> = (0..8).map(|k| corner(k, 0.0)).collect();
    let lens = Projection::Perspective { fov_deg: 24.0 };
    let camera = Camera::fit(&seen, Vector3::from(FROM), lens, size.width as f32 / size.height as f32);
    // The corners of the drawn volume fix the resolution of shadows, so that what rests looks the same in all frames.
    let [low, high] = [corner(0, BESIDE_M), corner(7, BESIDE_M)];
    let mut scene = DrawnMesh { positions: vec![low, high], ..DrawnMesh::default() };
    let mut triangles = Vec::new();
    for (actor, mesh) in actors {
        if let Some(key) = actor.at(at_s).filter(|key| (0..3).all(|k| (low[k]..high[k]).contains(&key.place_m[k]))) {
            scene.append(moved(mesh, key));
            triangles.extend((0..mesh.triangles.len()).map(|own| (&actor.shell, actor.look, own)));
        }
    }
    let texture = |triangle: usize, share: [f32; 3]| {
        let (shell, look, own) = triangles[triangle];
        let is_crack = own >= shell.outer.len();
        let corners = if is_crack { shell.cracks[own - shell.outer.len()] } else { shell.outer[own] };
        let place =
            (0..3).map(|k| Vector3::from(shell.positions[corners[k] as usize]) * share[k]).sum::<Vector3<f32>>();
        match look {
            Look::Piece(_) => glaze::finish(place + Vector3::from(shell.center_m), is_crack),
            Look::Steel | Look::Ground => Finish { color: Color::oklch(0.16, 0.01, 250.0), reflectance: 0.25 },
        }
    };
    let backdrop = Backdrop::Gradient(Color::oklch(0.64, 0.025, 68.0), Color::oklch(0.84, 0.022, 75.0));
    draw_textured(&scene, &texture, &camera, size, STYLE, Some(0.0), backdrop)
}
