//! The energy field that a diagram divides: masses on the nodes of a lifted lattice.

use super::Clusters;
use super::power::three_fifths;
use crate::lift::LiftedLattice;

/// Fraction of the mean energy density below which no node falls.
///
/// Small enough to change E_1 and the site density by less than 10⁻³ of themselves, large enough that cells without
/// strain energy have centroids.
pub const FLOOR: f64 = 1e-6;

/// Strain energy on the nodes of a lifted lattice, floored at [`FLOOR`] times the mean density.
///
/// Nothing computed from it depends on the unit of energy: masses times a power of two give the same diagram bit for
/// bit.
#[derive(Clone, Copy, Debug)]
pub struct EnergyField<'a> {
    lift: &'a LiftedLattice,
    mass: &'a [f64],
    volumes: &'a [f64],
    mean_density: f64,
    pinned: &'a [u32],
    clusters: Option<&'a Clusters>,
}

/// Why masses are no field. Nodes are named by their index.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// An array does not have one entry per node.
    #[error("{array} has {found} entries for {nodes} nodes")]
    Length {
        /// Which array.
        array: &'static str,
        /// Entries found.
        found: usize,
        /// Nodes of the lattice, from its volumes.
        nodes: usize,
    },
    /// A mass is negative, infinite or not a number.
    #[error("node {node} has energy {mass}")]
    Mass {
        /// The node.
        node: usize,
        /// Its mass.
        mass: f64,
    },
    /// A volume is not positive and finite.
    #[error("node {node} has volume {volume}")]
    Volume {
        /// The node.
        node: usize,
        /// Its volume.
        volume: f64,
    },
    /// A lifted coordinate, cell moment or density is not finite, or negative where it cannot be.
    #[error("the lift is out of range at node {node}")]
    Lift {
        /// The node.
        node: usize,
    },
    /// The energies add up to nothing, or to more than a number holds.
    #[error("the energies add up to {total}")]
    Total {
        /// Their sum.
        total: f64,
    },
}

impl<'a> EnergyField<'a> {
    /// A field on the nodes of `lift`: `volumes` in local length cubed, `mass` = w_v = ∫W over each node's share in any
    /// unit of energy, raised in place to the floor. All of length `nodes`.
    ///
    /// # Errors
    /// [`FieldError`] when an entry is out of range or the energies add up to nothing; `mass` is then unchanged.
    pub fn new(lift: &'a LiftedLattice, volumes: &'a [f64], mass: &'a mut [f64]) -> Result<Self, FieldError> {
        check_lengths(lift, volumes, mass)?;
        check_entries(lift, volumes)?;
        Self::on_checked(lift, volumes, mass)
    }

    /// The same where lift and volumes are an object's, whose entries were looked at when it was made or read.
    ///
    /// # Errors
    /// [`FieldError::Length`], [`FieldError::Mass`] and [`FieldError::Total`]; `mass` is then unchanged.
    pub fn on_checked(lift: &'a LiftedLattice, volumes: &'a [f64], mass: &'a mut [f64]) -> Result<Self, FieldError> {
        check_lengths(lift, volumes, mass)?;
        if let Some(node) = mass.iter().position(|mass| !(mass.is_finite() && *mass >= 0.0)) {
            return Err(FieldError::Mass { node, mass: mass[node] });
        }
        let total: f64 = mass.iter().sum();
        let mean_density = total / volumes.iter().sum::<f64>();
        if !mean_density.is_normal() {
            return Err(FieldError::Total { total });
        }
        for (mass, volume) in mass.iter_mut().zip(volumes) {
            *mass = mass.max(FLOOR * mean_density * volume);
        }
        Ok(Self { lift, mass, volumes, mean_density, pinned: &[], clusters: None })
    }

    /// The same with sites that stay where they are, on these nodes: the first of every diagram, as many as it has sites. They
    /// must be different nodes of the lattice.
    pub fn pinned(self, nodes: &'a [u32]) -> Self {
        Self { pinned: nodes, ..self }
    }

    /// The same with groups of the nodes, which spare work; other numbers of nodes' groups are not taken.
    pub fn grouped(self, clusters: &'a Clusters) -> Self {
        Self { clusters: Some(clusters).filter(|own| own.nodes() == Some(self.nodes())), ..self }
    }

    /// Groups of the nodes, if there are any.
    pub(super) fn clusters(&self) -> Option<&'a Clusters> {
        self.clusters
    }

    /// The same energy with other masses or another lift of the same nodes, which must be as [`Self::new`] wants them.
    pub(crate) fn like(self, lift: &'a LiftedLattice, mass: &'a [f64]) -> Self {
        Self { lift, mass, ..self }
    }

    /// Nodes of the sites that stay where they are.
    pub(crate) fn pins(&self) -> &'a [u32] {
        self.pinned
    }

    /// The lift.
    pub fn lift(&self) -> &'a LiftedLattice {
        self.lift
    }

    /// w_v, floored; length `nodes`.
    pub fn mass(&self) -> &'a [f64] {
        self.mass
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.mass.len()
    }

    /// m, the dimension of the lift.
    pub fn dimension(&self) -> usize {
        self.lift.dimension
    }

    /// ∫W / ∫dx before flooring; energy per local volume.
    pub fn mean_density(&self) -> f64 {
        self.mean_density
    }

    /// The mean of |X − p|² over node v's cell: |X_v − p|² + 2 b_v·(X_v − p) + m_v, without the first term.
    #[cfg(test)]
    pub(super) fn cell_moment(&self, node: usize, site: &[f64]) -> f64 {
        let offset = &self.lift.first_moment[node * self.lift.dimension..][..self.lift.dimension];
        let lever: f64 = self.lift.at(node).iter().zip(site).zip(offset).map(|((x, p), b)| (x - p) * b).sum();
        2.0 * lever + self.lift.second_moment[node]
    }

    /// W_v^(3/5) with W_v = w_v/V_v in units of [`Self::mean_density`].
    pub(crate) fn relative_density_three_fifths(&self, node: usize) -> f64 {
        three_fifths(self.relative_density(node))
    }

    /// W_v = w_v/V_v in units of [`Self::mean_density`].
    pub(crate) fn relative_density(&self, node: usize) -> f64 {
        self.mass[node] / self.volumes[node] / self.mean_density
    }

    /// V_v·W_v^(3/5)·(det g)^(1/5): node v's share of the optimal number of sites, up to a factor (Gersho 1979, Zador 1982,
    /// in dimension 3); W in units of [`Self::mean_density`].
    pub fn site_share(&self, node: usize) -> f64 {
        self.measure(node) * self.relative_density_three_fifths(node)
    }

    /// V_v, local volume.
    pub(crate) fn volume(&self, node: usize) -> f64 {
        self.volumes[node]
    }

    /// V_v·(det g)^(1/5), local volume.
    pub(crate) fn measure(&self, node: usize) -> f64 {
        self.volumes[node] * self.lift.density[node]
    }
}

fn check_lengths(lift: &LiftedLattice, volumes: &[f64], mass: &[f64]) -> Result<(), FieldError> {
    let nodes = volumes.len();
    let rows = |values: &[f64]| values.len() / lift.dimension.max(1);
    let lengths = [
        ("mass", mass.len()),
        ("second_moment", lift.second_moment.len()),
        ("density", lift.density.len()),
        ("coordinates / dimension", rows(&lift.coordinates)),
        ("first_moment / dimension", rows(&lift.first_moment)),
    ];
    match lengths.into_iter().find(|&(_, found)| found != nodes) {
        Some((array, found)) => Err(FieldError::Length { array, found, nodes }),
        None => Ok(()),
    }
}

fn check_entries(lift: &LiftedLattice, volumes: &[f64]) -> Result<(), FieldError> {
    if let Some(node) = volumes.iter().position(|volume| !(volume.is_finite() && *volume > 0.0)) {
        return Err(FieldError::Volume { node, volume: volumes[node] });
    }
    // Without an early exit, which would keep them from being vectorised.
    let finite = |values: &[f64]| values.iter().fold(true, |good, value| good & value.is_finite());
    let measure = |values: &[f64]| values.iter().fold(true, |good, value| good & (value.is_finite() & (*value >= 0.0)));
    let rows = finite(&lift.coordinates) && finite(&lift.first_moment);
    if rows && measure(&lift.second_moment) && measure(&lift.density) {
        return Ok(());
    }
    let whole = |node: usize| {
        let offset = &lift.first_moment[node * lift.dimension..][..lift.dimension];
        finite(lift.at(node)) && finite(offset) && measure(&[lift.second_moment[node], lift.density[node]])
    };
    Err(FieldError::Lift { node: (0..volumes.len()).find(|&node| !whole(node)).unwrap_or(0) })
}
