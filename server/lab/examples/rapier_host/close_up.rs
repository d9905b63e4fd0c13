//! Pictures of the painted vase: one in full size, and an animation in slow motion.

use super::Failure;
use super::film::{Film, Look};
use super::glaze;
use super::pictures::{is_floor, moved, paint};
use nalgebra::{Point3, Vector3};
use shatter_lab::picture::{
    AnimationFrame, Backdrop, Camera, Color, DrawnMesh, Finish, Image, PictureSize, Projection, RenderStyle,
    animated_png, draw_textured,
};

const STILL: PictureSize = PictureSize { width: 1200, height: 900 };
const FRAME: PictureSize = PictureSize { width: 440, height: 330 };

/// Time of the large picture after the break, s.
const STILL_S: f64 = 0.075;

/// Parts of the animation: time of the first frame after the break, s, simulated time per frame, s, and number of frames.
const PARTS: [(f64, f64, u32); 3] = [(-0.12, 1.0 / 120.0, 14), (0.0, 1.0 / 240.0, 24), (0.1, 1.0 / 120.0, 24)];

/// Time for which a frame is shown, and the last one, ms.
const DELAY_MS: u16 = 50;
const LAST_MS: u16 = 900;

/// Corners of the visible volume, m.
const SEEN_M: [[f32; 3]; 2] = [[-0.25, 0.0, -0.15], [0.25, 0.38, 0.15]];
/// Margin of the drawn volume around the visible one, m.
const BESIDE_M: f32 = 0.25;
/// Direction to the camera.
const FROM: [f32; 3] = [0.15, 0.40, 1.0];

const STYLE: RenderStyle = RenderStyle { key: 0.78, fill: 0.14, sky: 0.52, bounce: 0.24, gloss: 0.0 };

/// PNG of the fragments shortly after the break.
pub fn still(film: &Film) -> Result<Vec<u8>, Failure> {
    Ok(picture(film, break_s(film) + STILL_S, STILL).png()?)
}

/// Animated PNG of the fall and the break.
pub fn animation(film: &Film) -> Result<Vec<u8>, Failure> {
    let steps =
        PARTS.iter().flat_map(|(first_s, step_s, count)| (0..*count).map(move |k| first_s + step_s * f64::from(k)));
    let image = |after_s: f64| picture(film, (break_s(film) + after_s).max(0.0), FRAME);
    let mut frames: Vec<_> =
        steps.map(|after_s| AnimationFrame { image: image(after_s), delay_ms: DELAY_MS }).collect();
    frames.iter_mut().last().into_iter().for_each(|frame| frame.delay_ms = LAST_MS);
    Ok(animated_png(&frames)?)
}

/// Time of the first break; the begin of the film if nothing breaks.
fn break_s(film: &Film) -> f64 {
    film.actors.iter().filter_map(|actor| actor.gone_s).min_by(f64::total_cmp).unwrap_or_default()
}

fn picture(film: &Film, at_s: f64, size: PictureSize) -> Image {
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
    for actor in film.actors.iter().filter(|actor| !is_floor(actor)) {
        let key = actor.at(at_s).filter(|key| (0..3).all(|k| (low[k]..high[k]).contains(&key.place_m[k])));
        if let Some(key) = key {
            scene.append(moved(&paint(actor), key));
            triangles.extend((0..actor.shell.outer.len() + actor.shell.cracks.len()).map(|own| (actor, own)));
        }
    }
    let texture = |triangle: usize, share: [f32; 3]| {
        let (actor, own) = triangles[triangle];
        let shell = &actor.shell;
        let is_crack = own >= shell.outer.len();
        let corners = if is_crack { shell.cracks[own - shell.outer.len()] } else { shell.outer[own] };
        let place =
            (0..3).map(|k| Vector3::from(shell.positions[corners[k] as usize]) * share[k]).sum::<Vector3<f32>>();
        match actor.look {
            Look::Piece(_) => glaze::finish(place + Vector3::from(shell.center_m), is_crack),
            Look::Steel | Look::Ground => Finish { color: Color::oklch(0.45, 0.01, 250.0), glaze: 1.0 },
        }
    };
    let backdrop = Backdrop::Gradient(Color::oklch(0.70, 0.02, 80.0), Color::oklch(0.86, 0.02, 80.0));
    draw_textured(&scene, &texture, &camera, size, STYLE, Some(0.0), backdrop)
}
