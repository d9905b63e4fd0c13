//! Close-up of a contact: the input, and the fragments of the same impact on the input surface, with the lattices of each preset.

use super::settings::Bench;
use super::subject::ResultBuffers;
use super::{AccuracyFindings, StudyError};
use crate::picture::{
    Backdrop, CREASE_DEG, Camera, Color, DrawnMesh, Image, PictureSize, Projection, RenderStyle, Spread, draw,
};
use crate::report::{ReportFigure, ReportTable, Section, significant};
use crate::study::exploded::exploded;
use nalgebra::{Point3, Vector3};
use shatter_fracture::accuracy::{NORMAL_DEG, NormalShares};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{self, FractureRequest, PreparedObject, Workspace};
use shatter_fracture::surface::RawMesh;

/// Size of one picture.
const SIZE: PictureSize = PictureSize { width: 420, height: 420 };

/// Edge of the visible cube about the contact, over the diagonal.
const EDGE: f64 = 0.22;

/// Displacement of fragments over their distance from the contact.
const APART: f64 = 0.05;

/// Elevation of the camera above the outward direction of the impact, over the distance.
const ABOVE: f64 = 0.35;

/// Color of the input.
const WHOLE: Color = Color([0.55, 0.53, 0.49]);

/// Views of the same place of the input and of its fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloseUp {
    /// Direction from the contact to the camera; not normalized.
    from: [f32; 3],
    /// Edge of the visible cube, m.
    edge_m: f32,
    /// Views, the input first; meshes in meters, relative to the contact.
    views: Vec<View>,
}

/// One view.
#[derive(Clone, Debug, Default, PartialEq)]
struct View {
    name: &'static str,
    mesh: DrawnMesh,
    /// Fit of the lattice to the input; `None` for the input itself.
    fit: Option<Fit>,
}

/// Fit of a lattice's boundary to the input.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fit {
    crack_nodes: usize,
    /// Surface deviation over the diagonal.
    deviation: f64,
    normals: Option<NormalShares>,
}

impl Bench<'_> {
    /// Adds the fragments of the first impact on the lattices of a preset.
    pub(super) fn look(
        &mut self,
        name: &'static str,
        prepared: &PreparedObject,
        strike: &FractureRequest,
    ) -> Result<(), StudyError> {
        let contact = strike.contacts.first().ok_or(StudyError::Whole)?;
        let (hub_m, close_up) = (contact.point_m, &mut self.findings.close_up);
        if close_up.views.is_empty() {
            let out = Vector3::y() * ABOVE - contact.impulse_ns.normalize();
            let edge_m = (EDGE * prepared.frame.diagonal_m) as f32;
            let input = View { name: "input", mesh: whole(&self.plan.mesh, &hub_m), fit: None };
            *close_up = CloseUp { from: out.cast().into(), edge_m, views: vec![input] };
        }
        let fit = Fit {
            crack_nodes: prepared.crack_nodes(),
            deviation: prepared.report.surface_deviation,
            normals: NormalShares::of(prepared, NORMAL_DEG),
        };
        close_up.views.push(View { name, mesh: fractured(prepared, strike, &hub_m)?, fit: Some(fit) });
        Ok(())
    }
}

/// Mesh of the input, relative to `hub_m`.
fn whole(mesh: &RawMesh, hub_m: &Point3<f64>) -> DrawnMesh {
    let positions = mesh.positions_m.iter().map(|point| Point3::from((point - hub_m).cast::<f32>())).collect();
    DrawnMesh::paint(positions, mesh.triangles.clone(), CREASE_DEG, |_, _| WHOLE)
}

/// Fragments of a request, relative to `hub_m` and moved apart from there.
fn fractured(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    hub_m: &Point3<f64>,
) -> Result<DrawnMesh, StudyError> {
    let outcome = pipeline::strike(
        pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        &mut Workspace::default(),
    )?;
    let pieces = outcome.into_meshes().ok_or(StudyError::Whole)?;
    let mut buffers = ResultBuffers::default();
    buffers.emit(&pieces)?;
    let spread = Spread { hub_m: hub_m.coords.into(), factor: APART };
    Ok(exploded(&pieces.fragments, &pieces.runs, &buffers.positions, &buffers.indices, spread))
}

impl CloseUp {
    /// Picture of all views side by side, seen by the same camera; PNG. `None` if there is no impact.
    ///
    /// # Errors
    /// [`StudyError::Picture`].
    pub fn png(&self) -> Result<Option<Vec<u8>>, StudyError> {
        if self.views.is_empty() {
            return Ok(None);
        }
        let half = self.edge_m / 2.0;
        let ends = [-half, half];
        let cube = ends.iter().flat_map(|&x| ends.iter().flat_map(move |&y| ends.map(|z| Point3::new(x, y, z))));
        let points: Vec<Point3<f32>> = cube.collect();
        let camera = Camera::fit(&points, Vector3::from(self.from), Projection::Orthographic, 1.0);
        let drawn = |view: &View| draw(&view.mesh, &camera, SIZE, RenderStyle::STUDIO, None, Backdrop::Clear);
        let images: Vec<Image> = self.views.iter().map(drawn).collect();
        Ok(Some(Image::beside(&images).png()?))
    }

    /// Names of the views, from the left.
    pub fn names(&self) -> Vec<&'static str> {
        self.views.iter().map(|view| view.name).collect()
    }
}

/// Section of the page with the close-up; `png` is its picture.
pub(super) fn section(findings: &AccuracyFindings, png: Vec<u8>) -> Section {
    let close_up = &findings.close_up;
    let lead = "The first impact, on the lattices of each preset with the same number of sites; fragments are moved away from the contact.";
    let caption = format!("From the left: {}.", close_up.names().join(", "));
    let head =
        ["", "crack nodes", "surface deviation, % of the diagonal", "normals within 10°: flat", "smooth", "carried"];
    let share = |share: Option<f64>| share.map_or_else(|| "–".to_owned(), |share| significant(100.0 * share, 3) + " %");
    let row = |(name, fit): (&str, Fit)| {
        let normals = fit.normals;
        let shares = [normals.map(|own| own.faces), normals.map(|own| own.smooth), normals.and_then(|own| own.carried)];
        let text = [name.to_owned(), fit.crack_nodes.to_string(), significant(100.0 * fit.deviation, 3)];
        ("", text.into_iter().chain(shares.map(share)).collect())
    };
    let rows = close_up.views.iter().filter_map(|view| Some((view.name, view.fit?))).map(row).collect();
    Section {
        heading: "Close up".to_owned(),
        lead: vec![lead.to_owned()],
        figures: vec![ReportFigure { png, caption, scale: None }],
        tables: vec![ReportTable { head: head.map(str::to_owned).to_vec(), rows }],
        ..Section::default()
    }
}
