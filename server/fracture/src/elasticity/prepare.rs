//! What depends on the body alone: stiffness, factor, boundary, inertia.

use super::boundary::BoundaryNodes;
use super::element::{Element, Lame};
use super::energy::Elements;
use super::inertia::Inertia;
use super::rigid_support::check_anchors;
use super::solve::probe;
use super::{ElasticityError, NARROW_RESIDUAL_MAX, POISSON_MAX, PinnedNodes, RESIDUAL_MAX, Support};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;
use crate::sparse::{Cholesky, Precision, SymbolicFactor, SymmetricMatrix};
use nalgebra::Vector3;
use std::sync::{Arc, OnceLock};

/// An elastic body, ready for any number of impacts, which may be solved at the same time. Bodies that differ in how they are
/// held share everything else.
#[derive(Debug)]
pub struct Elasticity {
    pub(super) lame: Lame,
    pub(super) stiffness: Arc<SymmetricMatrix<3>>,
    /// Largest rounding of a row of K u, relative to ‖u‖: see [`row_rounding`].
    pub(super) row_rounding: f64,
    pub(super) symbolic: SymbolicFactor,
    /// Asked for.
    precision: Precision,
    /// Made at first need, by whoever needs it: the others wait. Making it hands nothing to other threads, so that no thread can
    /// come to wait for itself.
    factor: OnceLock<Result<Cholesky, ElasticityError>>,
    pub(super) support: Support,
    pub(super) elements: Arc<Elements>,
    pub(super) boundary: Arc<BoundaryNodes>,
    pub(super) inertia: Arc<Inertia>,
    /// Mean edge length of the lattice, local.
    pub(super) spacing: f64,
    pub(super) tets: usize,
}

impl Elasticity {
    /// Assembles and factors the stiffness of a free body with Young's modulus 1 and Poisson's ratio `poisson`
    /// (−1 < ν ≤ [`POISSON_MAX`]).
    ///
    /// # Errors
    /// [`ElasticityError::PoissonOutOfRange`], [`ElasticityError::LockingPoisson`],
    /// [`ElasticityError::EmptyLattice`], [`ElasticityError::DegenerateTet`], [`ElasticityError::Stiffness`],
    /// [`ElasticityError::Mechanism`], [`ElasticityError::Cancelled`].
    pub fn prepare(lattice: &Lattice, poisson: f64, token: &CancelToken) -> Result<Self, ElasticityError> {
        let elements = check(lattice, poisson)?;
        let pins = PinnedNodes::far_apart(lattice).ok_or(ElasticityError::EmptyLattice)?;
        Self::build(lattice, &elements, Lame::new(poisson), Support::Free(pins), token)?.factored(token)
    }

    /// As [`Self::prepare`], but factored and probed at first need, by [`Self::factor`] or by a solve: for a body that was
    /// factored before, while it was baked.
    ///
    /// # Errors
    /// As [`Self::prepare`], without [`ElasticityError::Mechanism`] and indefinite matrices.
    pub fn assembled(lattice: &Lattice, poisson: f64, token: &CancelToken) -> Result<Self, ElasticityError> {
        let elements = check(lattice, poisson)?;
        let pins = PinnedNodes::far_apart(lattice).ok_or(ElasticityError::EmptyLattice)?;
        Self::build(lattice, &elements, Lame::new(poisson), Support::Free(pins), token)
    }

    /// The same body, not factored yet, with a factor of this precision, if one in single precision is exact enough: if it leaves no
    /// more than [`NARROW_RESIDUAL_MAX`] of a load, each sweep of refinement taking away as much again. Slender bodies leave more; their
    /// factor is one in double precision all the same, as [`Self::precision`] tells.
    pub fn of_precision(self, precision: Precision) -> Self {
        Self { precision, factor: OnceLock::new(), ..self }
    }

    /// Of its factor: the one that it has, or, until then, the one asked for.
    pub fn precision(&self) -> Precision {
        let made = self.factor.get().and_then(|made| made.as_ref().ok());
        made.map_or(self.precision, Cholesky::precision)
    }

    /// A free body with any Poisson's ratio, for the measurement behind [`POISSON_MAX`].
    pub(crate) fn with_any_law(lattice: &Lattice, poisson: f64) -> Result<Self, ElasticityError> {
        let elements = check(lattice, 0.0)?;
        let pins = PinnedNodes::far_apart(lattice).ok_or(ElasticityError::EmptyLattice)?;
        let token = CancelToken::default();
        Self::build(lattice, &elements, Lame::new(poisson), Support::Free(pins), &token)?.factored(&token)
    }

    /// As [`Self::prepare`], held by `support`.
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

    /// The same body with `nodes` held in place, factored; it shares with this one all but its factor.
    ///
    /// # Errors
    /// Those of [`Self::check_anchors`] and [`Self::factor`], and [`ElasticityError::Cancelled`].
    pub fn anchored(&self, nodes: Vec<u32>, token: &CancelToken) -> Result<Self, ElasticityError> {
        self.check_anchors(&nodes)?;
        let held = Self {
            lame: self.lame,
            stiffness: self.stiffness.clone(),
            row_rounding: self.row_rounding,
            symbolic: self.symbolic.clone(),
            precision: self.precision,
            factor: OnceLock::new(),
            support: Support::Anchored(nodes),
            elements: self.elements.clone(),
            boundary: self.boundary.clone(),
            inertia: self.inertia.clone(),
            spacing: self.spacing,
            tets: self.tets,
        };
        held.factored(token)
    }

    /// Refuses anchors that do not hold the body.
    ///
    /// # Errors
    /// [`ElasticityError::UnknownAnchor`], [`ElasticityError::AnchorsInLine`].
    pub fn check_anchors(&self, nodes: &[u32]) -> Result<(), ElasticityError> {
        check_anchors(nodes, self.stiffness.nodes(), |node| self.inertia.arm(node))
    }

    /// The forces (three per node) that the acceleration `gravity` exerts on the body of unit density; exact for linear
    /// tetrahedra.
    pub fn weight(&self, gravity: &Vector3<f64>) -> Vec<f64> {
        let acceleration = [*gravity, Vector3::zeros()];
        (0..self.stiffness.nodes()).flat_map(|node| self.inertia.force(node, &acceleration).data.0[0]).collect()
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
        let symbolic = SymbolicFactor::analyse(&stiffness)?;
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
            support,
            elements,
            boundary,
            inertia,
            spacing,
            tets,
        })
    }

    fn factored(self, token: &CancelToken) -> Result<Self, ElasticityError> {
        self.factor()?;
        token.check()?;
        Ok(self)
    }

    /// The factor of the stiffness, probed; made by the first who asks, which cannot be interrupted.
    ///
    /// # Errors
    /// [`ElasticityError::Stiffness`], [`ElasticityError::Mechanism`]; the same ones ever after.
    pub fn factor(&self) -> Result<&Cholesky, ElasticityError> {
        let made = self.factor.get_or_init(|| {
            let mut held = SymmetricMatrix::clone(&self.stiffness);
            self.support.constrain(&mut held);
            if self.precision == Precision::F32
                && let Ok(factor) = self.symbolic.factor(&held, Precision::F32)
                && probe(self, &factor) <= NARROW_RESIDUAL_MAX
            {
                return Ok(factor);
            }
            let factor = self.symbolic.factor(&held, Precision::F64)?;
            match probe(self, &factor) {
                residual if residual <= RESIDUAL_MAX => Ok(factor),
                residual => Err(ElasticityError::Mechanism { residual }),
            }
        });
        made.as_ref().map_err(|error| *error)
    }

    /// Number of scalar unknowns, three per node.
    pub fn size(&self) -> usize {
        self.stiffness.size()
    }

    /// Mean edge length of the lattice, local: the unit of [`super::RADIUS_SPACINGS_MIN`].
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// How the body is held.
    pub fn support(&self) -> &Support {
        &self.support
    }

    /// Bytes of its stiffness.
    pub fn stiffness_bytes(&self) -> usize {
        self.stiffness.bytes()
    }

    /// Bytes of what it knows of its lattice: gradients, boundary, inertia.
    pub fn lattice_bytes(&self) -> usize {
        self.elements.bytes() + self.boundary.bytes() + self.inertia.bytes()
    }

    /// Bytes that its factor holds in the precision that was asked for, whether it is there or not.
    pub fn factor_bytes(&self) -> usize {
        self.symbolic.factor_bytes(self.precision)
    }

    /// Bytes that its factor would no longer hold in single precision.
    pub fn single_precision_saving(&self) -> usize {
        let bytes = |precision| self.symbolic.factor_bytes(precision);
        bytes(self.precision()) - bytes(Precision::F32)
    }

    /// Those of them that a body which is held otherwise does not share: its factor and its support.
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

/// The largest kε Σ|K_ij| over rows of k terms: the bound of an inner product's rounding (Higham, Accuracy and Stability
/// of Numerical Algorithms, 2002, section 3.1).
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
