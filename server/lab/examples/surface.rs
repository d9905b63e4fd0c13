//! Draws broken objects whose outer faces are the triangles of the input, and close-ups of their cracks.
//!
//! ```sh
//! cargo run --release -p shatter-lab --example surface -- FOLDER
//! ```
//!
//! It writes `surface.png`, with a generated head and a mug with a checkerboard texture, and `rims.png`, with the same impact on the head
//! in the presets `draft`, `game` and `film`. If `SHATTER_MESHES` names a folder with `horse.ply`, it also writes `surface-horse.png`.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{DegreeRequest, FractureMeshes, FractureRequest, PreparedObject, Preset};
use shatter_fracture::scene::{EffectKind, Material};
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use shatter_lab::picture::{
    Backdrop, CREASE_DEG, Camera, Color, DrawnMesh, Finish, Image, PictureSize, Projection, RenderStyle, draw_textured,
};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Error of the example.
type Failure = Box<dyn std::error::Error>;

const SIZE: PictureSize = PictureSize { width: 600, height: 560 };
const CLOSE_SIZE: PictureSize = PictureSize { width: 400, height: 360 };
const STYLE: RenderStyle = RenderStyle { key: 0.83, fill: 0.14, sky: 0.52, bounce: 0.24, gloss: 0.0 };
const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// Edge of the visible cube of a close-up, m.
const CLOSE_M: f32 = 0.062;

/// Number of times that normals are mixed with those of neighbors.
const SMOOTHINGS: usize = 3;

/// Fields of the checkerboard around the mug, and their height, m.
const FIELDS: f64 = 20.0;
const FIELD_M: f64 = 0.0125;

/// An object and its impact.
struct Subject {
    mesh: RawMesh,
    material: &'static str,
    /// A point near the contact, m; the nearest vertex is struck.
    near_m: [f64; 3],
    impulse_ns: [f64; 3],
    sites: u32,
    /// Direction to the camera.
    from: [f32; 3],
    is_checkered: bool,
}

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("surface"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let write =
        |name: &str, image: &Image| -> Result<(), Failure> { Ok(std::fs::write(folder.join(name), image.png()?)?) };
    let head = head();
    write("surface.png", &Image::beside(&[broken(&head, Preset::Game)?, broken(&mug(), Preset::Game)?]))?;
    let rims = [Preset::Draft, Preset::Game, Preset::Film].map(|preset| rim(&head, preset));
    write("rims.png", &Image::beside(&rims.into_iter().collect::<Result<Vec<_>, _>>()?))?;
    let meshes = std::env::var_os("SHATTER_MESHES").map(|folder| Path::new(&folder).join("horse.ply"));
    match meshes.filter(|file| file.is_file()) {
        Some(file) => write("surface-horse.png", &broken(&horse(&file)?, Preset::Game)?),
        None => Ok(()),
    }
}

fn head() -> Subject {
    let (near_m, impulse_ns) = ([0.045, 0.20, 0.07], [-6.0, -2.0, -9.0]);
    Subject {
        mesh: smooth(shapes::head()),
        material: "plaster",
        near_m,
        impulse_ns,
        sites: 30,
        from: [0.55, 0.12, 1.0],
        is_checkered: false,
    }
}

fn mug() -> Subject {
    let mut mesh = smooth(shapes::mug());
    mesh.attributes.uvs =
        mesh.triangles.iter().map(|own| around(&own.map(|vertex| mesh.positions_m[vertex as usize]))).collect();
    let (near_m, impulse_ns) = ([0.01, 0.06, 0.04], [0.0, 0.0, -2.0]);
    Subject { mesh, material: "ceramic", near_m, impulse_ns, sites: 24, from: [0.45, 0.55, 1.0], is_checkered: true }
}

fn horse(file: &Path) -> Result<Subject, Failure> {
    let mut mesh = surface::read(file, LengthUnit::M, UpAxis::Z)?;
    let [low, high] = bounds(mesh.positions_m.iter());
    let factor = 0.5 / (high - low).norm();
    let middle = nalgebra::center(&low, &high);
    mesh.positions_m.iter_mut().for_each(|point| *point = Point3::from((*point - middle) * factor));
    let (near_m, impulse_ns) = ([0.1, 0.05, 0.0], [-12.0, 0.0, 0.0]);
    Ok(Subject {
        mesh,
        material: "plaster",
        near_m,
        impulse_ns,
        sites: 40,
        from: [1.0, 0.25, -0.55],
        is_checkered: false,
    })
}

/// Texture coordinates around the y axis, one per corner: a triangle across the seam continues beyond it.
fn around(corners: &[Point3<f64>; 3]) -> [[f32; 2]; 3] {
    let angles = corners.each_ref().map(|point| point.z.atan2(point.x));
    let turned = |angle: f64| angle - TAU * ((angle - angles[0]) / TAU).round();
    [0, 1, 2].map(|k| [(turned(angles[k]) / TAU * FIELDS) as f32, (corners[k].y / FIELD_M) as f32])
}

/// Gives the corners of a mesh mean normals around its vertices: what is generated on a grid has many narrow triangles.
fn smooth(mut mesh: RawMesh) -> RawMesh {
    let mut sums = vec![Vector3::zeros(); mesh.positions_m.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| mesh.positions_m[vertex as usize]);
        triangle.iter().for_each(|&vertex| sums[vertex as usize] += (b - a).cross(&(c - a)));
    }
    for _ in 0..SMOOTHINGS {
        let before = sums.clone();
        for [a, b, c] in &mesh.triangles {
            [[a, b], [b, c], [c, a]].into_iter().for_each(|[from, to]| sums[*to as usize] += before[*from as usize]);
        }
    }
    let normal = |vertex: u32| sums[vertex as usize].normalize().map(|x| x as f32).into();
    mesh.attributes.normals = mesh.triangles.iter().map(|own| own.map(normal)).collect();
    mesh
}

fn bounds<'a>(points: impl Iterator<Item = &'a Point3<f64>>) -> [Point3<f64>; 2] {
    let all = [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])];
    points.fold(all, |[low, high], point| [low.inf(point), high.sup(point)])
}

impl Subject {
    fn prepared(&self, quality: Preset) -> Result<PreparedObject, Failure> {
        let request =
            BakeRequest { quality, ..BakeRequest::new("shown", self.material, Material::named(self.material)?) };
        Ok(bake(self.mesh.clone(), &request, &CancelToken::default(), &mut |_| {})?)
    }

    fn contact_m(&self) -> Point3<f64> {
        let near = Point3::from(self.near_m);
        let distance = |point: &&Point3<f64>| (**point - near).norm_squared();
        self.mesh.positions_m.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).copied().unwrap_or(near)
    }

    fn fractured(&self, quality: Preset) -> Result<FractureMeshes, Failure> {
        let strike = FractureRequest::at(self.contact_m(), self.impulse_ns.into()).seeded(1).of_quality(quality);
        let effects = strike.effects.with(EffectKind::Attributes);
        let strike = FractureRequest { degree: DegreeRequest::Sites(self.sites), effects, ..strike };
        let outcome = self.prepared(quality)?.strike(&strike)?;
        Ok(outcome.into_meshes().ok_or("the object stays whole")?)
    }
}

/// Fragments moved apart, on the ground.
fn broken(subject: &Subject, quality: Preset) -> Result<Image, Failure> {
    let meshes = subject.fractured(quality)?;
    let drawn = Drawn::new(&meshes, 0.16)?;
    let camera = Camera::fit(&drawn.mesh.positions, subject.from.into(), LENS, SIZE.width as f32 / SIZE.height as f32);
    let ground = drawn.mesh.positions.iter().fold(f32::INFINITY, |low, point| low.min(point.y));
    Ok(drawn.image(&camera, SIZE, Some(ground), subject.is_checkered))
}

/// Close-up of the contact, the fragments slightly apart.
fn rim(subject: &Subject, quality: Preset) -> Result<Image, Failure> {
    let drawn = Drawn::new(&subject.fractured(quality)?, 0.02)?;
    let hub = subject.contact_m().cast::<f32>();
    let cube: Vec<Point3<f32>> = (0..8)
        .map(|k| hub + Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { CLOSE_M / 2.0 } else { -CLOSE_M / 2.0 }))
        .collect();
    let camera = Camera::fit(&cube, [0.7, 0.2, 1.0].into(), LENS, CLOSE_SIZE.width as f32 / CLOSE_SIZE.height as f32);
    Ok(drawn.image(&camera, CLOSE_SIZE, None, false))
}

/// Fragments as a mesh, with texture coordinates of outer triangles.
struct Drawn {
    mesh: DrawnMesh,
    /// Texture coordinates of each triangle; `None` on cracks.
    uvs: Vec<Option<[[f32; 2]; 3]>>,
}

impl Drawn {
    /// Moves each fragment by `factor` of its distance from the center of all.
    fn new(meshes: &FractureMeshes, factor: f64) -> Result<Self, Failure> {
        let emitted = meshes.emitted()?;
        let [low, high] =
            bounds(meshes.fragments.iter().map(|own| Point3::from(own.center_m)).collect::<Vec<_>>().iter());
        let hub = nalgebra::center(&low, &high);
        let mut drawn = Self { mesh: DrawnMesh::default(), uvs: Vec::new() };
        for fragment in emitted.fragments() {
            let center = Point3::from(fragment.row.center_m);
            let place: Vector3<f32> = (center.coords + (center - hub) * factor).cast();
            let positions = fragment.positions.iter().map(|&position| Point3::from(position) + place).collect();
            let triangles: Vec<[u32; 3]> = fragment.indices.as_chunks::<3>().0.to_vec();
            let mut mesh = DrawnMesh::paint(positions, triangles, CREASE_DEG, |_, _| Color([0.0; 3]));
            let own = &meshes.attributes.vertices[fragment.row.vertex_first as usize..][..fragment.positions.len()];
            for (triangle, corners) in mesh.triangles.iter().zip(&mut mesh.corners) {
                let looks = triangle.map(|vertex| &own[vertex as usize]);
                let is_crack = looks.iter().any(|look| look.normal == [0.0; 3]);
                drawn.uvs.push((!is_crack).then(|| looks.map(|look| look.uv)));
                for (corner, look) in corners.iter_mut().zip(looks).filter(|_| !is_crack) {
                    corner.normal = look.normal.into();
                }
            }
            drawn.mesh.append(mesh);
        }
        Ok(drawn)
    }

    fn image(&self, camera: &Camera, size: PictureSize, ground: Option<f32>, is_checkered: bool) -> Image {
        let [light, dark] = [Color::oklch(0.93, 0.015, 90.0), Color::oklch(0.45, 0.10, 250.0)];
        let clay = Finish { color: Color::oklch(0.62, 0.09, 52.0), reflectance: 0.0 };
        let texture = |triangle: usize, share: [f32; 3]| {
            let Some(uvs) = &self.uvs[triangle] else { return clay };
            let field = [0, 1].map(|axis| (0..3).map(|k| uvs[k][axis] * share[k]).sum::<f32>().floor());
            let is_dark = is_checkered && (field[0] + field[1]).rem_euclid(2.0) > 0.5;
            Finish { color: if is_dark { dark } else { light }, reflectance: 0.02 }
        };
        let backdrop = Backdrop::Gradient(Color::oklch(0.66, 0.02, 250.0), Color::oklch(0.86, 0.015, 250.0));
        draw_textured(&self.mesh, &texture, camera, size, STYLE, ground, backdrop)
    }
}
