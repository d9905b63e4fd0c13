//! Application of an artist's controls to an object when it is loaded: warped lifts, regions that keep one label, fixed
//! sites, painted densities.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014); A.
//! Gersho, *Asymptotically optimal block quantization* (1979): the density of sites is the energy density to the power
//! 3/5, so f times as many sites need f^(5/3) times the energy.

use super::object::{PreparedBody, PreparedObject};
use super::region_boundary::RegionBoundary;
use super::warped_body::{WarpError, WarpedBody};
use crate::cancel_token::CancelToken;
use crate::cutting::CuttingMesh;
use crate::lattice::Lattice;
use crate::lift::{self, Extension, LiftError, LiftKind, LiftedLattice, SpaceWarp};
use crate::scene::{Grain, Paint, Region, WarpControls, Waves};
use crate::surface::{LocalFrame, NearestPoints};
use nalgebra::{Point3, Unit, Vector3};
use std::collections::BTreeSet;

/// Largest slope that is proposed; a slope of 0.3 is strong already.
const SLOPE_MAX: f64 = 4.0;

/// Bisection steps in the search for the steepest waves that do not fold.
const SLOPE_STEPS: usize = 8;

impl PreparedObject {
    /// Applies `controls` to the object, for requests with the effect `warp`. Random waves derive from the object's own
    /// seed.
    ///
    /// # Errors
    /// [`WarpError`], naming the control.
    pub fn warped(mut self, controls: &WarpControls, token: &CancelToken) -> Result<Self, WarpError> {
        if controls.is_silent() {
            return Ok(self);
        }
        let least_m = 2.0 * self.parameters.crack_spacing * self.frame.diagonal_m;
        if let Some(Waves { length_m, .. }) = controls.waves.filter(|waves| waves.length_m < least_m) {
            return Err(WarpError::Short { length_m, least_m });
        }
        let warp = warp(controls, &self);
        self.unfolded(controls, &warp)?;
        for index in 0..self.bodies.len() {
            let lifts = if warp.is_identity() { Vec::new() } else { self.bent(index, &warp, token)? };
            let factors = controls
                .paint
                .as_ref()
                .map_or(Vec::new(), |paint| painted(paint, &self.bodies[index].crack, &self.frame));
            let alike = controls.grain.is_none() && controls.paint.is_none();
            self.bodies[index].warped = Some(WarpedBody { lifts, factors, alike, ..WarpedBody::default() });
        }
        self.protect(controls)?;
        self.pin(controls)?;
        Ok(self)
    }

    /// Rejects waves under which some body folds, and proposes a slope under which none does.
    fn unfolded(&self, controls: &WarpControls, warp: &SpaceWarp) -> Result<(), WarpError> {
        let fold = |warp: &SpaceWarp| {
            let mut bodies = self.bodies.iter().enumerate();
            bodies.find_map(|(index, body)| Some((index, warp.lattice(&body.crack).err()?)))
        };
        let Some((index, tet)) = fold(warp) else { return Ok(()) };
        let holds = |slope: f64| {
            let waves = controls.waves.map(|waves| Waves { slope, ..waves });
            fold(&self::warp(&WarpControls { waves, ..controls.clone() }, self)).is_none()
        };
        let mut range = [0.0, controls.waves.map_or(0.0, |waves| waves.slope.min(SLOPE_MAX))];
        for _ in 0..SLOPE_STEPS {
            let middle = 0.5 * (range[0] + range[1]);
            range[usize::from(!holds(middle))] = middle;
        }
        // Two digits, rounded down, so that the user can copy it.
        let unit = 10f64.powf(range[0].log10().floor() - 1.0);
        let rounded = format!("{:.1e}", (range[0] / unit).floor() * unit).parse().ok();
        Err(self.folds(index, tet, rounded.filter(|slope| *slope > 0.0 && holds(*slope))))
    }

    /// The error for space that folds at tetrahedron `tet` of body `index`.
    fn folds(&self, index: usize, tet: usize, slope: Option<f64>) -> WarpError {
        let corners = self.bodies[index].crack.corners(tet);
        let center = corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0;
        WarpError::Folds { body: index, at_m: self.frame.to_meters(&Point3::from(center)).coords.into(), slope }
    }

    /// The lifts of body `index`, computed in the warped space, with moments and density on the original lattice.
    fn bent(&self, index: usize, warp: &SpaceWarp, token: &CancelToken) -> Result<Vec<LiftedLattice>, WarpError> {
        let body = &self.bodies[index];
        let crack = &body.crack;
        let bent = warp.lattice(crack).map_err(|tet| self.folds(index, tet, None))?;
        let (modes, alpha) = (self.parameters.modes, self.parameters.alpha);
        let mut lifts = vec![Ok(LiftedLattice::euclidean(&bent))];
        if body.interior.is_some() {
            lifts.push(lift::interior(&bent, modes, alpha, token).map_err(|source| (LiftKind::Interior, source)));
        }
        if body.surface_diffusion.is_some() {
            let made = lift::surface_diffusion(&bent, Extension::Harmonic, lift::SURFACE_MODES_DEFAULT, token);
            lifts.push(made.map_err(|source| (LiftKind::SurfaceDiffusion, source)));
        }
        let or_without_lift = |made: Result<LiftedLattice, (LiftKind, LiftError)>| match made {
            Ok(lift) => {
                let lift = LiftedLattice::scaled(lift.kind, crack, lift.dimension, lift.coordinates);
                let finite = lift.coordinates.iter().chain(&lift.density).all(|value| value.is_finite());
                let (body, kind) = (index, lift.kind);
                let refused = || WarpError::Lift { body, lift: kind, source: LiftError::NotFinite };
                if finite { Ok(lift) } else { Err(refused()) }
            }
            Err((_, LiftError::Canceled(canceled))) => Err(WarpError::Canceled(canceled)),
            Err((lift, source)) => Err(WarpError::Lift { body: index, lift, source }),
        };
        lifts.into_iter().map(or_without_lift).collect()
    }

    /// Finds the nodes of protected regions: those inside, and those within one edge length of them; and the boundaries of
    /// the regions on the meshes.
    ///
    /// Regions that share a node form one group.
    fn protect(&mut self, controls: &WarpControls) -> Result<(), WarpError> {
        let frame = self.frame;
        let mut found = vec![false; controls.protected.len()];
        for body in &mut self.bodies {
            let reach_m = longest_edge(&body.crack) * frame.diagonal_m;
            let mut groups: Vec<(BTreeSet<u32>, Vec<Region>)> = Vec::new();
            for (region, found) in controls.protected.iter().zip(&mut found) {
                let near = |node: &Point3<f64>| region.distance_m(&frame.to_meters(node)) <= reach_m;
                let nodes = body.crack.nodes.iter().enumerate().filter(|(_, node)| near(node));
                let mut own = (nodes.map(|(node, _)| node as u32).collect::<BTreeSet<_>>(), vec![*region]);
                if own.0.is_empty() {
                    continue;
                }
                *found = true;
                let (sharing, others): (Vec<_>, Vec<_>) =
                    std::mem::take(&mut groups).into_iter().partition(|(nodes, _)| !nodes.is_disjoint(&own.0));
                for (nodes, regions) in sharing {
                    own.0.extend(nodes);
                    own.1.extend(regions);
                }
                groups = others;
                groups.push(own);
            }
            body.protect(groups, frame);
        }
        match found.iter().position(|found| !found) {
            Some(region) => Err(WarpError::Region { region }),
            None => Ok(()),
        }
    }

    /// Finds the nodes nearest to the fixed sites. Sites on the same node count once.
    fn pin(&mut self, controls: &WarpControls) -> Result<(), WarpError> {
        for (site, point_m) in controls.sites_m.iter().enumerate() {
            let local = self.frame.to_local(point_m);
            let nearest = |(index, crack): (usize, &Lattice)| {
                let nodes = crack.nodes.iter().enumerate();
                let distances = nodes.map(|(node, place)| (index, node as u32, (place - local).norm()));
                distances.min_by(|a, b| a.2.total_cmp(&b.2))
            };
            let cracks = self.bodies.iter().map(|body| &body.crack).enumerate();
            let Some((index, node, distance)) = cracks.filter_map(nearest).min_by(|a, b| a.2.total_cmp(&b.2)) else {
                continue;
            };
            let body = &mut self.bodies[index];
            if distance > longest_edge(&body.crack) {
                return Err(WarpError::Site { site, distance_m: distance * self.frame.diagonal_m });
            }
            if let Some(warped) = body.warped.as_mut().filter(|warped| !warped.pins.contains(&node)) {
                warped.pins.push(node);
            }
        }
        Ok(())
    }
}

impl PreparedBody {
    /// Sets the nodes and boundaries of groups of protected regions, if there are any.
    fn protect(&mut self, groups: Vec<(BTreeSet<u32>, Vec<Region>)>, frame: LocalFrame) {
        let Some(warped) = self.warped.as_mut().filter(|_| !groups.is_empty()) else { return };
        let (nodes, regions): (Vec<_>, Vec<_>) = groups.into_iter().unzip();
        warped.protected = nodes.into_iter().map(|own| own.into_iter().collect()).collect();
        warped.boundary = Some(RegionBoundary::new((&self.crack, &self.topology), &regions, frame, |_| {}));
        let of_cutting = |cutting: &CuttingMesh| {
            let mesh = (&cutting.mesh, &cutting.topology);
            RegionBoundary::new(mesh, &regions, frame, |groups| cutting.join_short_edges(groups))
        };
        warped.cutting_boundary = self.cutting.as_ref().map(of_cutting);
    }
}

fn warp(controls: &WarpControls, prepared: &PreparedObject) -> SpaceWarp {
    let mut warp = SpaceWarp::default();
    if let Some(Grain { axis, ratio }) = controls.grain {
        warp = warp.grain(Unit::new_normalize(axis), ratio);
    }
    if let Some(Waves { length_m, slope }) = controls.waves {
        warp = warp.waves(length_m / prepared.frame.diagonal_m, slope, prepared.parameters.seed);
    }
    warp
}

/// Factor of the nearest painted point to the power 5/3, by node.
fn painted(paint: &Paint, crack: &Lattice, frame: &LocalFrame) -> Vec<f64> {
    let nearest = NearestPoints::new(&paint.points_m);
    let factor = |node: &Point3<f64>| {
        let factor = paint.factors[nearest.to(&frame.to_meters(node))];
        factor * factor.cbrt().powi(2)
    };
    crack.nodes.iter().map(factor).collect()
}

fn longest_edge(lattice: &Lattice) -> f64 {
    let length = |edge: &[u32; 2]| (lattice.nodes[edge[0] as usize] - lattice.nodes[edge[1] as usize]).norm();
    lattice.edges().iter().map(length).fold(0.0, f64::max)
}
