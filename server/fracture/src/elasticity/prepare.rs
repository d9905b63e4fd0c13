//! Preparation of elastic bodies: stiffness, factor, boundary and inertia.

use super::blocks::Elements;
use super::boundary::BoundaryNodes;
use super::element::{Element, Lame};
use super::inertia::Inertia;
use super::quadratic::{EdgeFunctions, ElementOrder};
use super::rigid_support::check_anchors;
use super::solve::probe;
use super::{ElasticityError, NARROW_RESIDUAL_MAX, POISSON_MAX, PinnedNodes, RESIDUAL_MAX, Support};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::sparse::{Cholesky, Precision, SymbolicFactor, SymmetricMatrix};
use nalgebra::Vector3;
use std::sync::{Arc, OnceLock};

/// Elastic body, prepared for impacts, which may be solved concurrently.
///
/// Bodies that differ only in their support share everything but the factor.
#[derive(Debug)]
pub struct Elasticity {
    /// Lamé's constants.
    pub(super) lame: Lame,
    /// Stiffness matrix of the free body.
    pub(super) stiffness: Arc<SymmetricMatrix<3>>,
    /// Largest rounding error of a row of K u, relative to ‖u‖; see [`row_rounding`].
    pub(super) row_rounding: f64,
    /// Symbolic factorization of the stiffness.
    pub(super) symbolic: SymbolicFactor,
    /// Requested precision of the factor.
    precision: Precision,
    /// Factor, made on first use; other threads that need it wait.
    ///
    /// Making it submits no work to other threads, so a thread cannot wait for itself.
    factor: OnceLock<Result<Cholesky, ElasticityError>>,
    /// Displacement under the test load that the factor failed.
    pub(super) failed: OnceLock<Vec<f64>>,
    /// Support of the body.
    pub(super) support: Support,
    /// Gradients and volumes of the tetrahedra.
    pub(super) elements: Arc<Elements>,
    /// Boundary of the lattice.
    pub(super) boundary: Arc<BoundaryNodes>,
    /// Mass distribution.
    pub(super) inertia: Arc<Inertia>,
    /// Edge functions of quadratic elements; `None`: the elements are linear.
    pub(super) edges: Option<Arc<EdgeFunctions>>,
    /// Mean edge length of the lattice, local.
    pub(super) spacing: f64,
    /// Number of tetrahedra.
    pub(super) tets: usize,
}

impl Elasticity {
    /// Assembles and factors the stiffness of a free body.
    ///
    /// Young's modulus is 1. Poisson's ratio is `poisson`, −1 < ν ≤ [`POISSON_MAX`].
    ///
    /// # Errors
    /// [`ElasticityError::PoissonOutOfRange`], [`ElasticityError::LockingPoisson`],
    /// [`ElasticityError::EmptyLattice`], [`ElasticityError::DegenerateTet`], [`ElasticityError::Stiffness`],
    /// [`ElasticityError::Mechanism`], [`ElasticityError::Canceled`].
    pub fn prepare(lattice: &Lattice, poisson: f64, token: &CancelToken) -> Result<Self, ElasticityError> {
        let elements = check(lattice, poisson)?;
        let pins = PinnedNodes::far_apart(lattice).ok_or(ElasticityError::EmptyLattice)?;
        Self::build(lattice, &elements, Lame::new(poisson), Support::Free(pins), token)?.factored(token)
    }

    /// As [`Self::prepare`], but factored and tested on first use, by [`Self::factor`] or by a solve.
    ///
    /// Meant for bodies that were factored before, during baking.
    ///
    /// # Errors
    /// As [`Self::prepare`], without [`ElasticityError::Mechanism`] and indefinite matrices.
    pub fn assembled(lattice: &Lattice, poisson: f64, token: &CancelToken) -> Result<Self, ElasticityError> {
        let elements = check(lattice, poisson)?;
        let pins = PinnedNodes::far_apart(lattice).ok_or(ElasticityError::EmptyLattice)?;
        Self::build(lattice, &elements, Lame::new(poisson), Support::Free(pins), token)
    }

    /// Returns the same body, not yet factored, with a factor of this precision.
    ///
    /// A single-precision factor is used only if it leaves at most [`NARROW_RESIDUAL_MAX`] of a load; each sweep of
    /// refinement reduces the rest by the same ratio. Slender bodies leave more and get a double-precision factor,
    /// which [`Self::precision`] reports.
    #[must_use]
    pub fn of_precision(self, precision: Precision) -> Self {
        Self { precision, factor: OnceLock::new(), failed: OnceLock::new(), ..self }
    }

    /// Returns the same body with elements of this order on `lattice`, the lattice that it was made of.
    ///
    /// The factor remains that of the linear elements, which solves with quadratic ones use as a preconditioner.
    ///
    /// # Errors
    /// [`ElasticityError::OtherLattice`], [`ElasticityError::DegenerateTet`].
    pub fn of_order(self, order: ElementOrder, lattice: &Lattice) -> Result<Self, ElasticityError> {
        let (expected, found) = (self.tets, lattice.tets.len());
        if expected != found || lattice.nodes.len() * 3 != self.size() {
            return Err(ElasticityError::OtherLattice { what: "the lattice", expected, found });
        }
        let made = || EdgeFunctions::new(lattice, self.lame, |node| self.inertia.arm(node));
        let edges = match order {
            ElementOrder::Linear => None,
            ElementOrder::Quadratic => Some(Arc::new(made().ok_or(ElasticityError::DegenerateTet { tet: 0 })?)),
        };
        Ok(Self { edges, ..self })
    }

    /// Order of the elements.
    pub fn order(&self) -> ElementOrder {
        if self.edges.is_some() { ElementOrder::Quadratic } else { ElementOrder::Linear }
    }

    /// Precision of the factor: that of the existing factor, or until then the requested one.
    pub fn precision(&self) -> Precision {
        let made = self.factor.get().and_then(|made| made.as_ref().ok());
        made.map_or(self.precision, Cholesky::precision)
    }

    /// Free body with any Poisson's ratio, for the measurement behind [`POISSON_MAX`].
    pub(crate) fn with_any_law(lattice: &Lattice, poisson: f64) -> Result<Self, ElasticityError> {
        let elements = check(lattice, 0.0)?;
        let pins = PinnedNodes::far_apart(lattice).ok_or(ElasticityError::EmptyLattice)?;
        let token = CancelToken::default();
        Self::build(lattice, &elements, Lame::new(poisson), Support::Free(pins), &token)?.factored(&token)
    }

    /// As [`Self::prepare`], with the given `support`.
    ///
    /// # Errors
    /// As [`Self::prepare`], and [`ElasticityError::UnknownAnchor`], [`ElasticityError::AnchorsInLine`].
    pub fn supported(
        lattice: &Lattice,
        poisson: f64,
        support: Support,
        token: &CancelToken,
    ) -> Result<Self, ElasticityError> {
        let elements = check(lattice, poisson)?;
        if let Support::Anchored(nodes) = &support {
            check_anchors(nodes, lattice.nodes.len(), |node| lattice.nodes[node].coords)?;
        }
        Self::build(lattice, &elements, Lame::new(poisson), support, token)?.factored(token)
    }

    /// Returns the same body, anchored at `nodes` (ascending) and factored. It shares everything but the factor with
    /// `self`.
    ///
    /// # Errors
    /// Those of [`Self::check_anchors`] and [`Self::factor`], and [`ElasticityError::Canceled`].
    pub fn anchored(&self, nodes: Vec<u32>, token: &CancelToken) -> Result<Self, ElasticityError> {
        self.anchored_unfactored(nodes)?.factored(token)
    }

    /// As [`Self::anchored`], but factored on first use.
    ///
    /// # Errors
    /// Those of [`Self::check_anchors`].
    pub fn anchored_unfactored(&self, nodes: Vec<u32>) -> Result<Self, ElasticityError> {
        self.check_anchors(&nodes)?;
        let held = self.sharing(self.stiffness.clone(), self.row_rounding, Support::Anchored(nodes));
        Ok(Self { edges: self.edges.clone(), ..held })
    }

    /// Body of linear elements with another `stiffness` of the same pattern, not yet factored. It shares everything else.
    pub(super) fn with_stiffness(&self, stiffness: SymmetricMatrix<3>) -> Self {
        let row_rounding = row_rounding(&stiffness);
        self.sharing(Arc::new(stiffness), row_rounding, self.support.clone())
    }

    /// Body of linear elements with another stiffness and support, not yet factored. It shares everything else.
    fn sharing(&self, stiffness: Arc<SymmetricMatrix<3>>, row_rounding: f64, support: Support) -> Self {
        Self {
            lame: self.lame,
            stiffness,
            row_rounding,
            symbolic: self.symbolic.clone(),
            precision: self.precision,
            factor: OnceLock::new(),
            failed: OnceLock::new(),
            support,
            elements: self.elements.clone(),
            boundary: self.boundary.clone(),
            inertia: self.inertia.clone(),
            edges: None,
            spacing: self.spacing,
            tets: self.tets,
        }
    }

    /// Rejects anchors that leave a rigid motion free.
    ///
    /// # Errors
    /// [`ElasticityError::UnknownAnchor`], [`ElasticityError::AnchorsInLine`].
    pub fn check_anchors(&self, nodes: &[u32]) -> Result<(), ElasticityError> {
        check_anchors(nodes, self.stiffness.nodes(), |node| self.inertia.arm(node))
    }

    /// Forces ([`Self::unknowns`]) of the acceleration `gravity` on the body of unit density, consistent with the elements.
    pub fn weight(&self, gravity: &Vector3<f64>) -> Vec<f64> {
        let acceleration = [*gravity, Vector3::zeros()];
        let nodes = (0..self.stiffness.nodes()).map(|node| self.inertia.force(node, &acceleration));
        let edges = self.edges.iter().flat_map(|edges| (0..edges.count()).map(move |edge| (edges, edge)));
        let edge_part = edges.map(|(edges, edge)| edges.inertial_force(edge, &acceleration));
        nodes.chain(edge_part).flat_map(|force| force.data.0[0]).collect()
    }

    fn build(
        lattice: &Lattice,
        elements: &[Element],
        lame: Lame,
        support: Support,
        token: &CancelToken,
    ) -> Result<Self, ElasticityError> {
        let inertia = Inertia::new(lattice).ok_or(ElasticityError::EmptyLattice)?;
        let stiffness = SymmetricMatrix::assemble(lattice.nodes.len(), &lattice.tets, |tet, i, j| {
            elements[tet].stiffness(i, j, lame)
        })?;
        token.check()?;
        let symbolic = SymbolicFactor::analyze(&stiffness)?;
        token.check()?;
        let (boundary, spacing) = (Arc::new(BoundaryNodes::new(lattice)), mean_edge_length(lattice));
        let tets = lattice.tets.len();
        let (row_rounding, elements) = (row_rounding(&stiffness), Arc::new(Elements::new(elements)));
        let (stiffness, inertia, factor) = (Arc::new(stiffness), Arc::new(inertia), OnceLock::new());
        Ok(Self {
            lame,
            stiffness,
            row_rounding,
            symbolic,
            precision: Precision::F64,
            factor,
            failed: OnceLock::new(),
            support,
            elements,
            boundary,
            inertia,
            edges: None,
            spacing,
            tets,
        })
    }

    fn factored(self, token: &CancelToken) -> Result<Self, ElasticityError> {
        self.factor()?;
        token.check()?;
        Ok(self)
    }

    /// Factor of the stiffness, tested with a load. The first caller computes it, which cannot be interrupted.
    ///
    /// # Errors
    /// [`ElasticityError::Stiffness`], [`ElasticityError::Mechanism`]; the same ones ever after.
    pub fn factor(&self) -> Result<&Cholesky, ElasticityError> {
        let made = self.factor.get_or_init(|| {
            let mut held = SymmetricMatrix::clone(&self.stiffness);
            self.support.constrain(&mut held);
            if self.precision == Precision::F32
                && let Ok(factor) = self.symbolic.factor(&held, Precision::F32)
                && probe(self, &factor).0 <= NARROW_RESIDUAL_MAX
            {
                return Ok(factor);
            }
            let factor = self.symbolic.factor(&held, Precision::F64)?;
            match probe(self, &factor) {
                (residual, _) if residual <= RESIDUAL_MAX => Ok(factor),
                (residual, displacement) => {
                    self.failed.get_or_init(|| displacement);
                    Err(ElasticityError::Mechanism { residual })
                }
            }
        });
        made.as_ref().map_err(|error| *error)
    }

    /// Number of scalar unknowns of the nodes, three per node.
    pub fn size(&self) -> usize {
        self.stiffness.size()
    }

    /// Length of forces and displacements: three per node, then three per edge if the elements are quadratic.
    pub fn unknowns(&self) -> usize {
        self.size() + 3 * self.edges.as_ref().map_or(0, |edges| edges.count())
    }

    /// Mean edge length of the lattice, local: the unit of [`super::RADIUS_SPACINGS_MIN`].
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Support of the body.
    pub fn support(&self) -> &Support {
        &self.support
    }

    /// Bytes of the stiffness matrix.
    pub fn stiffness_bytes(&self) -> usize {
        self.stiffness.bytes()
    }

    /// Bytes of the data that depend on the lattice: gradients, boundary, inertia.
    pub fn lattice_bytes(&self) -> usize {
        self.elements.bytes() + self.boundary.bytes() + self.inertia.bytes() + self.edge_bytes()
    }

    /// Bytes of the edge functions of quadratic elements.
    pub fn edge_bytes(&self) -> usize {
        self.edges.as_ref().map_or(0, |edges| edges.bytes())
    }

    /// Bytes of the factor in the requested precision, whether it exists or not.
    pub fn factor_bytes(&self) -> usize {
        self.symbolic.factor_bytes(self.precision)
    }

    /// Bytes that the factor takes beyond [`Self::factor_bytes`] in double precision; 0 if that was requested.
    pub fn double_precision_bytes(&self) -> usize {
        self.symbolic.factor_bytes(Precision::F64) - self.factor_bytes()
    }

    /// True if single precision was requested and the factor keeps double precision, because that is too inaccurate.
    pub fn rejects_single_precision(&self) -> bool {
        self.precision == Precision::F32 && self.precision() == Precision::F64
    }

    /// Multiplications and additions to compute the factor.
    pub fn factor_operations(&self) -> u64 {
        self.symbolic.factor_operations()
    }

    /// Bytes that a single-precision factor would save if it is accurate enough; 0 if that precision was requested.
    pub fn single_precision_saving(&self) -> usize {
        let bytes = |precision| self.symbolic.factor_bytes(precision);
        bytes(self.precision) - bytes(Precision::F32)
    }

    /// Bytes that a body with another support does not share: those of its factor and its support.
    pub fn own_bytes(&self) -> usize {
        self.symbolic.factor_bytes(self.precision()) + self.support.bytes()
    }
}

fn check(lattice: &Lattice, poisson: f64) -> Result<Vec<Element>, ElasticityError> {
    if !(poisson > -1.0 && poisson < 0.5) {
        return Err(ElasticityError::PoissonOutOfRange { poisson });
    }
    if poisson > POISSON_MAX {
        return Err(ElasticityError::LockingPoisson { poisson });
    }
    if lattice.tets.is_empty() {
        return Err(ElasticityError::EmptyLattice);
    }
    (0..lattice.tets.len())
        .map(|tet| Element::new(lattice, tet).ok_or(ElasticityError::DegenerateTet { tet }))
        .collect()
}

/// Largest kε Σ|K_ij| over rows of k terms.
///
/// This bounds the rounding error of an inner product (Higham, *Accuracy and Stability of Numerical
/// Algorithms*, 2002, section 3.1).
fn row_rounding(stiffness: &SymmetricMatrix<3>) -> f64 {
    let row = |node: usize| {
        let blocks = stiffness.row(node).1;
        let sums = blocks.iter().map(|block| block.abs()).sum::<nalgebra::Matrix3<f64>>().column_sum();
        f64::EPSILON * (3 * blocks.len()) as f64 * sums.max()
    };
    (0..stiffness.nodes()).map(row).fold(0.0, f64::max)
}

fn mean_edge_length(lattice: &Lattice) -> f64 {
    let edges = lattice.edges();
    let length = |edge: &[u32; 2]| {
        let [a, b] = edge.map(|node| lattice.nodes[node as usize]);
        (b - a).norm()
    };
    edges.iter().map(length).sum::<f64>() / edges.len() as f64
}
