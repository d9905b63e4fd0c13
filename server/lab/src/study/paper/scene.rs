//! Body of both figures, and the drawing of their panels.

use super::{DIAGONAL_M, Panel, PaperError, PaperPlan};
use crate::picture::{Backdrop, Camera, DrawnMesh, Image, PictureSize, Projection, RenderStyle, draw};
use crate::study::gallery::GalleryResult;
use nalgebra::{Point3, Vector3};
use shatter_export::contact::{ContactBody, ElasticMaterial, HertzContact};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{DegreeRequest, FractureRequest, PreparedObject, SurfaceKind};
use shatter_fracture::scene::{EffectKind, Material};
use shatter_fracture::surface::RawMesh;

/// Material of the body.
const MATERIAL: &str = "ceramic";

/// Size of a panel.
const SIZE: PictureSize = PictureSize { width: 480, height: 480 };

/// Long lens, which hardly shortens distant objects.
const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// Displacement of fragments over their distance from the body's center.
pub const SPREAD: f64 = 0.3;

/// Body of both figures.
pub struct PaperBody {
    pub prepared: PreparedObject,
    /// Vertices of the input, m.
    pub vertices_m: Vec<Point3<f64>>,
    /// Direction from which balls and camera come.
    pub from: Vector3<f64>,
    /// Template of the requests.
    strike: FractureRequest,
}

/// Contact of the body with a ball or the floor.
pub struct PaperContact {
    pub point_m: Point3<f64>,
    /// Direction of the impulse on the body.
    pub direction: Vector3<f64>,
    pub partner: ContactBody,
    pub speed_m_s: f64,
    /// Radius of curvature of the body at the contact, m; infinite where it is flat.
    pub own_radius_m: f64,
    /// γ over the body's own γ.
    pub gamma_factor: f64,
}

impl PaperBody {
    pub fn new(plan: &PaperPlan) -> Result<Self, PaperError> {
        let mesh = scaled(&plan.mesh).ok_or(PaperError::Empty)?;
        let material = Material::named(MATERIAL).map_err(|error| PaperError::Materials(error.to_string()))?;
        let request = BakeRequest {
            quality: plan.quality,
            surface: SurfaceKind::Lattice,
            ..BakeRequest::new(plan.name.clone(), MATERIAL, material)
        };
        let vertices_m = mesh.positions_m.clone();
        let prepared = bake(mesh, &request, &CancelToken::default(), &mut |_| {})?;
        let strike = FractureRequest::at(Point3::origin(), Vector3::x()).seeded(1).of_quality(plan.quality);
        // Nothing was learned, so the closed form estimates the degree, and diagrams verify it.
        // The paper merges no pieces.
        let effects = strike.effects.without(EffectKind::Slivers);
        let strike = FractureRequest { degree: DegreeRequest::Verified, effects, ..strike };
        Ok(Self { prepared, vertices_m, from: Vector3::from(plan.from), strike })
    }

    pub fn mass_kg(&self) -> f64 {
        self.prepared.report.lattice_volume_m3 * self.prepared.parameters.material.density_kg_m3
    }

    /// Contact partner with a surface of this radius.
    fn partner(&self, radius_m: f64) -> ContactBody {
        let material = &self.prepared.parameters.material;
        let material = ElasticMaterial { young_pa: material.young_pa, poisson: material.poisson };
        ContactBody { material, mass_kg: self.mass_kg(), radius_m }
    }

    /// Strikes with the contact of Hertz theory: a collision without energy loss transfers J = 2 m* v.
    pub fn strike(
        &self,
        paper_contact: &PaperContact,
        radius_m: f64,
        caption: String,
    ) -> Result<(Panel, GalleryResult), PaperError> {
        let own = self.partner(paper_contact.own_radius_m);
        let hertz = HertzContact::of(&own, &paper_contact.partner, paper_contact.speed_m_s)?;
        let effective_kg = 1.0 / (1.0 / own.mass_kg + 1.0 / paper_contact.partner.mass_kg);
        let impulse_ns = 2.0 * effective_kg * paper_contact.speed_m_s;
        let mut strike = self.strike.clone();
        for contact in &mut strike.contacts {
            contact.point_m = paper_contact.point_m;
            contact.impulse_ns = paper_contact.direction.normalize() * impulse_ns;
            contact.duration_s = Some(hertz.duration_s);
            contact.radius_m = Some(hertz.radius_m);
        }
        let gamma_j_m2 = paper_contact.gamma_factor * self.prepared.gamma_j_m2;
        strike.gamma_j_m2 = Some(gamma_j_m2);
        let result = GalleryResult::new(&self.prepared, &strike)?;
        let mass_kg =
            if paper_contact.partner.mass_kg.is_finite() { paper_contact.partner.mass_kg } else { own.mass_kg };
        let panel = Panel {
            caption,
            mass_kg,
            radius_m,
            speed_m_s: paper_contact.speed_m_s,
            impulse_ns,
            duration_s: hertz.duration_s,
            contact_radius_m: hertz.radius_m,
            gamma_j_m2,
            e1_over_gamma: result.e1_over_gamma,
            sites: result.sites,
            fragments: result.pieces.fragments.len(),
        };
        Ok((panel, result))
    }
}

/// Scales `mesh` to the diagonal of both figures, about its center.
fn scaled(mesh: &RawMesh) -> Option<RawMesh> {
    let first = *mesh.positions_m.first()?;
    let (low, high) =
        mesh.positions_m.iter().fold((first, first), |(low, high), point| (low.inf(point), high.sup(point)));
    let (middle, diagonal_m) = (nalgebra::center(&low, &high), (high - low).norm());
    let factor = Some(DIAGONAL_M / diagonal_m).filter(|factor| factor.is_normal())?;
    let mut scaled = mesh.clone();
    scaled.positions_m.iter_mut().for_each(|point| *point = Point3::from((*point - middle) * factor));
    Some(scaled)
}

/// Draws all panels with the same camera from `from`, on the ground below the lowest point.
pub fn pictures(meshes: &[DrawnMesh], from: Vector3<f32>) -> Vec<Image> {
    let points: Vec<_> = meshes.iter().flat_map(|mesh| mesh.positions.iter().copied()).collect();
    let camera = Camera::fit(&points, from, LENS, SIZE.width as f32 / SIZE.height as f32);
    let ground = points.iter().fold(f32::INFINITY, |low, point| low.min(point.y));
    meshes.iter().map(|mesh| draw(mesh, &camera, SIZE, RenderStyle::STUDIO, Some(ground), Backdrop::Clear)).collect()
}
