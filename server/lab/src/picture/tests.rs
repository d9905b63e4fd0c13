//! Tests of pictures of simple shapes.

use super::*;
use nalgebra::{Point3, Vector3};

const SIZE: PictureSize = PictureSize { width: 96, height: 72 };

/// Sphere of radius 1 around the origin.
fn ball(rings: u32) -> DrawnMesh {
    let sides = 2 * rings;
    let mut positions = Vec::new();
    for ring in 0..=rings {
        let (sin, cos) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
        for side in 0..sides {
            let turn = std::f32::consts::TAU * side as f32 / sides as f32;
            positions.push(Point3::new(sin * turn.cos(), cos, -sin * turn.sin()));
        }
    }
    let quad = |ring: u32, side: u32| {
        let next = (side + 1) % sides;
        let [a, b] = [ring * sides + side, ring * sides + next];
        [[a, a + sides, b + sides], [a, b + sides, b]]
    };
    let triangles = (0..rings).flat_map(|ring| (0..sides).flat_map(move |side| quad(ring, side))).collect();
    DrawnMesh::paint(positions, triangles, 60.0, |_, _| Color([0.5; 3]))
}

fn picture(mesh: &DrawnMesh, projection: Projection, ground: Option<f32>) -> Image {
    let camera = Camera::fit(&mesh.positions, Vector3::new(0.3, 0.4, 1.0), projection, 96.0 / 72.0);
    draw(mesh, &camera, SIZE, RenderStyle::STUDIO, ground, Backdrop::Clear)
}

/// Bounds of opaque pixels: (left, right, top, bottom).
fn extent(image: &Image) -> [usize; 4] {
    let solid = image.pixels.iter().enumerate().filter(|(_, pixel)| pixel[3] > 200);
    solid.fold([usize::MAX, 0, usize::MAX, 0], |[left, right, top, bottom], (at, _)| {
        let (x, y) = (at % image.size.width, at / image.size.width);
        [left.min(x), right.max(x), top.min(y), bottom.max(y)]
    })
}

#[test]
fn the_camera_fills_the_picture_and_cuts_nothing_off() {
    for projection in [Projection::Orthographic, Projection::Perspective { fov_deg: 30.0 }] {
        let [left, right, top, bottom] = extent(&picture(&ball(24), projection, None));
        let height = (bottom - top + 1) as f32 / SIZE.height as f32;
        assert!((0.84..0.95).contains(&height), "{projection:?}: {height}");
        let centered = |low: usize, high: usize, count: usize| (low + high).abs_diff(count - 1) <= 2;
        assert!(centered(left, right, SIZE.width) && centered(top, bottom, SIZE.height), "{projection:?}");
    }
}

#[test]
fn the_nearer_thing_is_seen() {
    let red = arrow(Point3::new(0.0, 0.0, 3.0), -Vector3::z(), 1.0, Color([1.0, 0.0, 0.0]));
    let mut mesh = ball(16);
    mesh.append(red);
    let camera = Camera::fit(&mesh.positions, Vector3::z(), Projection::Orthographic, 96.0 / 72.0);
    let image = draw(&mesh, &camera, SIZE, RenderStyle::CHART, None, Backdrop::Clear);
    let middle = image.pixels[SIZE.height / 2 * SIZE.width + SIZE.width / 2];
    assert!(middle[0] > 2 * middle[1], "{middle:?}");
}

#[test]
fn light_falls_from_above_and_shadow_on_the_ground() {
    let image = picture(&ball(24), Projection::Orthographic, Some(-1.0));
    let at = |x: usize, y: usize| image.pixels[y * SIZE.width + x];
    assert!(at(48, 14)[1] > at(48, 58)[1]);
    let opacity = image.pixels.iter().filter(|pixel| (1..200).contains(&pixel[3])).count();
    assert!(opacity > 100, "no shadow on the ground: {opacity} pixels");
    assert_eq!(at(2, 2)[3], 0);
}

#[test]
fn edges_are_smoothed() {
    let image = picture(&ball(24), Projection::Orthographic, None);
    let partial = image.pixels.iter().filter(|pixel| (20..235).contains(&pixel[3])).count();
    assert!(partial > 60, "{partial}");
}

#[test]
fn a_picture_does_not_depend_on_the_number_of_threads() {
    let mesh = ball(12);
    let drawn = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&mesh, Projection::Perspective { fov_deg: 40.0 }, Some(-1.0)))
    };
    assert_eq!(drawn(1), drawn(3));
}

#[test]
fn a_png_holds_the_pixels() {
    let image = Image::beside(&[
        picture(&ball(8), Projection::Orthographic, None),
        Image { size: SIZE, pixels: vec![[9; 4]; 96 * 72] },
    ]);
    let bytes = image.png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (192, 72));
    assert_eq!(pixels, image.pixels.as_flattened());
}

#[test]
fn a_glaze_reflects_the_key_light_and_a_matte_texture_does_not() {
    let mesh = ball(24);
    let camera = Camera::fit(&mesh.positions, Vector3::z(), Projection::Orthographic, 96.0 / 72.0);
    let brightest = |reflectance| {
        let texture = |_, _: [f32; 3]| Finish { color: Color([0.1; 3]), reflectance };
        let image = draw_textured(&mesh, &texture, &camera, SIZE, RenderStyle::CHART, None, Backdrop::Clear);
        image.pixels.iter().map(|pixel| pixel[1]).max().unwrap()
    };
    assert!(brightest(0.0) < 130 && brightest(0.04) > 170, "{} {}", brightest(0.0), brightest(0.04));
}

#[test]
fn an_animation_repeats_and_stores_only_what_changes() {
    let still = Image { size: SIZE, pixels: vec![[200, 100, 50, 255]; 96 * 72] };
    let mut other = still.clone();
    for row in 10..13 {
        other.pixels[row * 96 + 20..row * 96 + 25].fill([10, 20, 240, 255]);
    }
    let images = [still.clone(), other.clone(), other, still];
    let frames = images.clone().map(|image| AnimationFrame { image, delay_ms: 40 });
    let mut reader = png::Decoder::new(std::io::Cursor::new(animated_png(&frames).unwrap())).read_info().unwrap();
    let animation = *reader.info().animation_control().unwrap();
    assert_eq!((animation.num_frames, animation.num_plays), (4, 0));
    let palette = reader.info().palette.clone().unwrap();
    let mut shown = vec![0; 96 * 72];
    let rectangles = [[0, 0, 96, 72], [20, 10, 5, 3], [0, 0, 1, 1], [20, 10, 5, 3]];
    for (image, rectangle) in images.iter().zip(rectangles) {
        let mut entries = vec![0; 96 * 72];
        reader.next_frame(&mut entries).unwrap();
        let frame = *reader.info().frame_control().unwrap();
        assert_eq!([frame.x_offset, frame.y_offset, frame.width, frame.height], rectangle);
        for (at, entry) in entries.iter().take((frame.width * frame.height) as usize).enumerate() {
            let (x, y) = (at % frame.width as usize, at / frame.width as usize);
            let place = (y + frame.y_offset as usize) * 96 + x + frame.x_offset as usize;
            shown[place] = if *entry == 0 { shown[place] } else { *entry };
        }
        for (entry, pixel) in shown.iter().zip(&image.pixels) {
            let color = &palette[3 * usize::from(*entry)..][..3];
            assert!((0..3).all(|k| color[k].abs_diff(pixel[k]) <= 4), "{color:?} {pixel:?}");
        }
    }
    assert!(animated_png(&[]).is_err());
}

#[test]
fn an_empty_scene_is_an_empty_picture() {
    let image = picture(&DrawnMesh::default(), Projection::Orthographic, Some(0.0));
    assert!(image.pixels.iter().all(|pixel| pixel[3] == 0));
}
