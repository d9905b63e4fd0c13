//! First hit of a ray on an object or on a retained fragment.
//!
//! The surface is the one onto which contacts are projected, so a hit is never too far from it: the input surface where
//! fragments have that, else the boundary of the crack lattice.

use super::error::{FractureError, RAY_ORIGIN_MAX_M};
use super::output::cut_domain::{cut_mesh, cutting};
use super::output::retained::RetainedFragments;
use super::prepared::fragment_surface::FragmentSurface;
use super::prepared::object::{PreparedBody, PreparedObject};
use super::prepared::parameters::SurfaceKind;
use super::restrike::parent::inner;
use crate::elasticity::{BoundaryNodes, ClosestApproach, FaceSearch, RayHit};
use crate::surface::LocalFrame;
use crate::tessellation::{EarlierCracks, fragment_faces};
use nalgebra::{Point3, Vector3};

/// A ray, in the coordinates of the mesh file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AimRay {
    /// Origin, m.
    pub origin_m: Point3<f64>,
    /// Direction, of any length above zero.
    pub direction: Vector3<f64>,
}

/// First hit of a ray on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Index of the body that the ray hits.
    pub body: usize,
    /// Surface that it hits.
    pub surface: SurfaceKind,
    /// Hit point, m.
    pub point_m: Point3<f64>,
    /// Outward unit normal at the point.
    pub normal: Vector3<f64>,
    /// Distance from the origin of the ray to the point, m.
    pub distance_m: f64,
}

/// The first hit of `ray` on the object, whose fragments have the surface `kind` if it has that.
///
/// # Errors
/// [`FractureError::RayDirection`], [`FractureError::RayOrigin`], [`FractureError::RayMissed`].
pub fn aim(prepared: &PreparedObject, kind: SurfaceKind, ray: &AimRay) -> Result<SurfaceHit, FractureError> {
    let bodies = prepared.bodies.iter().enumerate().map(|(index, body)| (index, body.contact_surface(kind)));
    let hit = first(&prepared.frame, bodies, ray)?;
    let is_exact = kind == SurfaceKind::Exact && prepared.bodies[hit.body].cutting.is_some();
    Ok(if is_exact { SurfaceHit { surface: SurfaceKind::Exact, ..hit } } else { hit })
}

/// The first hit of `ray` on fragment `fragment` of the retained result `kept`.
///
/// With an exact surface, the surface is that of the fragment, cracks included. Else it is that of the fragment's whole
/// tetrahedra, which a request on the fragment loads. It lies up to one spacing of the crack lattice within the
/// fragment's surface.
///
/// # Errors
/// As [`aim`], and [`FractureError::UnknownFragment`], [`FractureError::FragmentSmall`], [`FractureError::OtherObject`].
pub fn aim_again(
    prepared: &PreparedObject,
    (kept, fragment): (&RetainedFragments, u32),
    ray: &AimRay,
) -> Result<SurfaceHit, FractureError> {
    let (old, label) = kept.find(fragment)?;
    let fits = |body: &&PreparedBody| cut_mesh(body, kept.surface()).nodes.len() == old.labels.len();
    let body = prepared.bodies.get(old.body).filter(fits).ok_or(FractureError::OtherObject)?;
    let cracks = EarlierCracks { labels: &old.labels, points: &old.points };
    if let Some(cutting) = cutting(body, kept.surface()) {
        let surface = FragmentSurface::new(fragment_faces(&cutting.mesh, &cutting.topology, cracks, label));
        let hit = first(&prepared.frame, std::iter::once((old.body, surface.search())), ray)?;
        return Ok(SurfaceHit { surface: SurfaceKind::Exact, ..hit });
    }
    let (lattice, _) = inner(&body.crack, &old.labels, label).ok_or(FractureError::FragmentSmall { fragment })?;
    first(&prepared.frame, std::iter::once((old.body, BoundaryNodes::new(&lattice).search())), ray)
}

impl PreparedObject {
    /// Volume of the meshes on which the bodies are cut, m³: the sum of the volumes of their fragments.
    pub fn volume_m3(&self) -> f64 {
        let volumes =
            self.bodies.iter().map(|body| body.cutting.as_ref().map_or(&body.volumes, |cutting| &cutting.volumes));
        volumes.flatten().sum::<f64>() * self.frame.diagonal_m.powi(3)
    }

    /// Lowest and highest corner of the bounding box of the crack lattices, m.
    pub fn bounds_m(&self) -> [Point3<f64>; 2] {
        let corners =
            self.bodies.iter().flat_map(|body| &body.boundary.positions).map(|local| self.frame.to_meters(local));
        let empty = [f64::INFINITY, f64::NEG_INFINITY].map(|end| Point3::new(end, end, end));
        corners.fold(empty, |[low, high], corner| [low.inf(&corner), high.sup(&corner)])
    }
}

fn first<'a>(
    frame: &LocalFrame,
    surfaces: impl Iterator<Item = (usize, FaceSearch<'a>)> + Clone,
    ray: &AimRay,
) -> Result<SurfaceHit, FractureError> {
    let direction = ray.direction.try_normalize(0.0).filter(|unit| unit.iter().all(|x| x.is_finite()));
    let direction = direction.ok_or(FractureError::RayDirection)?;
    let origin_distance_m = nalgebra::distance(&ray.origin_m, &frame.center_m);
    if origin_distance_m.is_nan() || origin_distance_m > RAY_ORIGIN_MAX_M {
        return Err(FractureError::RayOrigin);
    }
    let origin = frame.to_local(&ray.origin_m);
    let hits =
        surfaces.clone().filter_map(|(body, surface)| Some((body, surface, surface.first_hit(&origin, &direction)?)));
    let nearer = |a: &(usize, FaceSearch<'a>, RayHit), b: &(usize, FaceSearch<'a>, RayHit)| {
        a.2.distance.total_cmp(&b.2.distance)
    };
    match hits.min_by(nearer) {
        Some((body, surface, hit)) => Ok(SurfaceHit {
            body,
            surface: SurfaceKind::Lattice,
            point_m: frame.to_meters(&hit.place),
            normal: surface.normal(hit.face),
            distance_m: hit.distance * frame.diagonal_m,
        }),
        None => Err(missed(frame, surfaces.filter_map(|(_, surface)| surface.closest_approach(&origin, &direction)))),
    }
}

fn missed(frame: &LocalFrame, approaches: impl Iterator<Item = ClosestApproach>) -> FractureError {
    match approaches.min_by(|a, b| a.distance.total_cmp(&b.distance)) {
        Some(ClosestApproach { on_ray, on_boundary, distance }) => FractureError::RayMissed {
            ray: frame.to_meters(&on_ray),
            surface: frame.to_meters(&on_boundary),
            distance: distance * frame.diagonal_m,
            unit_m: 1.0,
        },
        None => FractureError::OtherObject,
    }
}
