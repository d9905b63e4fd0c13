//! Energy field that a diagram partitions: masses on the nodes of a lifted lattice.

use super::Clusters;
use super::power::three_fifths;
use crate::lift::LiftedLattice;

/// Smallest energy density of a node, over the mean density.
///
/// It is small enough to change E_1 and the site density by less than 10⁻³, relatively, and large enough that cells
/// without strain energy have centroids.
pub const FLOOR: f64 = 1e-6;

/// Strain energy on the nodes of a lifted lattice, floored at [`FLOOR`] times the mean density.
///
/// Results do not depend on the unit of energy: masses times a power of two yield the same diagram bit for bit.
#[derive(Clone, Copy, Debug)]
pub struct EnergyField<'a> {
    lift: &'a LiftedLattice,
    mass: &'a [f64],
    volumes: &'a [f64],
    mean_density: f64,
    pinned: &'a [u32],
    clusters: Option<&'a Clusters>,
}

/// Error of an energy field. Nodes are given by index.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// An array does not have one entry per node.
    #[error("{array} has {found} entries for {nodes} nodes")]
    Length {
        /// Name of the array.
        array: &'static str,
        /// Number of entries found.
        found: usize,
        /// Number of nodes of the lattice, from its volumes.
        nodes: usize,
    },
    /// A mass is negative, infinite or not a number.
    #[error("node {node} has energy {mass}")]
    Mass {
        /// Index of the node.
        node: usize,
        /// Mass of the node.
        mass: f64,
    },
    /// A volume is not positive and finite.
    #[error("node {node} has volume {volume}")]
    Volume {
        /// Index of the node.
        node: usize,
        /// Volume of the node.
        volume: f64,
    },
    /// A lifted coordinate, cell moment or density is not finite, or is negative where it must not be.
    #[error("the lift is out of range at node {node}")]
    Lift {
        /// Index of the node.
        node: usize,
    },
    /// The energies sum to zero or overflow.
    #[error("the energies add up to {total}; the sum must be positive and finite")]
    Total {
        /// Sum of the energies.
        total: f64,
    },
}

impl<'a> EnergyField<'a> {
    /// Creates a field on the nodes of `lift`.
    ///
    /// `volumes` are in local length cubed. `mass` is w_v = ∫W over each node's share, in any unit of energy; it is
    /// raised to the floor in place. Both have length `nodes`.
    ///
    /// # Errors
    /// [`FieldError`] when an entry is out of range or the energies add up to nothing; `mass` is then unchanged.
    pub fn new(lift: &'a LiftedLattice, volumes: &'a [f64], mass: &'a mut [f64]) -> Result<Self, FieldError> {
        check_lengths(lift, volumes, mass)?;
        check_entries(lift, volumes)?;
        Self::on_checked(lift, volumes, mass)
    }

    /// As [`Self::new`], for a lift and volumes whose entries were checked when the object was made or read.
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

    /// Sets pinned sites at these nodes.
    ///
    /// They are the first sites of every diagram, as many as it has sites, and do not move. They must be different
    /// nodes of the lattice.
    #[must_use]
    pub fn pinned(self, nodes: &'a [u32]) -> Self {
        Self { pinned: nodes, ..self }
    }

    /// Sets groups of the nodes, which reduce work. Groups of another number of nodes are ignored.
    #[must_use]
    pub fn grouped(self, clusters: &'a Clusters) -> Self {
        Self { clusters: Some(clusters).filter(|own| own.nodes() == Some(self.nodes())), ..self }
    }

    /// Groups of the nodes, if any.
    pub(super) fn clusters(&self) -> Option<&'a Clusters> {
        self.clusters
    }

    /// The same energy with other masses or another lift of the same nodes. Both must satisfy
    /// the conditions of [`Self::new`].
    pub(crate) fn like(self, lift: &'a LiftedLattice, mass: &'a [f64]) -> Self {
        Self { lift, mass, ..self }
    }

    /// Nodes of the pinned sites.
    pub(crate) fn pins(&self) -> &'a [u32] {
        self.pinned
    }

    /// Lift of the field.
    pub fn lift(&self) -> &'a LiftedLattice {
        self.lift
    }

    /// Floored masses w_v; length `nodes`.
    pub fn mass(&self) -> &'a [f64] {
        self.mass
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.mass.len()
    }

    /// Dimension m of the lift.
    pub fn dimension(&self) -> usize {
        self.lift.dimension
    }

    /// Mean energy density ∫W / ∫dx before flooring; energy per local volume.
    pub fn mean_density(&self) -> f64 {
        self.mean_density
    }

    /// Mean of |X − p|² over node v's cell without the term |X_v − p|²: 2 b_v·(X_v − p) + m_v.
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

    /// Energy density W_v = w_v/V_v in units of [`Self::mean_density`].
    pub(crate) fn relative_density(&self, node: usize) -> f64 {
        self.mass[node] / self.volumes[node] / self.mean_density
    }

    /// Node v's share of the optimal number of sites, up to a factor: V_v·W_v^(3/5)·(det g)^(1/5).
    ///
    /// W is in units of [`Self::mean_density`] (Gersho 1979, Zador 1982, in dimension 3).
    pub fn site_share(&self, node: usize) -> f64 {
        self.measure(node) * self.relative_density_three_fifths(node)
    }

    /// Volume V_v of a node, local.
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
    // No early exit, because it would prevent vectorization.
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
