//! A contact of an impact.

use nalgebra::{Point3, Vector3};

/// One contact, in the coordinates of the mesh file (meters, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactContact {
    /// Contact point, m.
    pub point_m: Point3<f64>,
    /// Impulse on the object, N·s.
    pub impulse_ns: Vector3<f64>,
    /// Contact duration, s; `None`: the scene's default.
    pub duration_s: Option<f64>,
    /// Contact radius, m; `None`: the scene's default.
    pub radius_m: Option<f64>,
    /// Body that strikes the object here; `None`: unknown, the energy of the load has no limit.
    pub partner: Option<ImpactPartner>,
}

/// Body that strikes the object at a contact, and how fast. Coordinates as of [`ImpactContact`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactPartner {
    /// Its number: contacts with the same number have the same partner.
    pub id: u64,
    /// Mass, kg; infinite: it does not move.
    pub mass_kg: f64,
    /// Center of mass, m; of no effect without inertia.
    pub center_m: Point3<f64>,
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz. All zero: it does not rotate.
    pub inertia_kg_m2: [f64; 6],
    /// Closing speed of partner and object along the impulse, m/s; negative where they separate.
    pub speed_m_s: f64,
}

/// Reason why the partners of an impact do not limit its energy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PartnerError {
    /// Some contacts have a partner, this one has none.
    #[error(
        "contact {contact} has no partner, but another contact has one; give a partner for all contacts or for none"
    )]
    Missing {
        /// Index of the contact.
        contact: usize,
    },
    /// The mass is not above zero.
    #[error("contact {contact}: the mass of the partner must be above zero, infinite if it does not move; got {value}")]
    Mass {
        /// Index of the contact.
        contact: usize,
        /// Its value, kg.
        value: f64,
    },
    /// A number of the partner is not finite.
    #[error("contact {contact}: the {key} of the partner must be finite, got {value}")]
    Number {
        /// Index of the contact.
        contact: usize,
        /// Name of the number.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// The inertia tensor is neither zero nor positive definite.
    #[error("contact {contact}: the inertia of the partner must be positive definite, or zero if it does not rotate")]
    Inertia {
        /// Index of the contact.
        contact: usize,
    },
    /// Two contacts have the same partner, with different properties.
    #[error("contacts {} and {} have the same partner, but another {key}; give both the same, or partners of their own", .contacts[0], .contacts[1])]
    Differs {
        /// Indices of the contacts.
        contacts: [usize; 2],
        /// Name of the property.
        key: &'static str,
    },
    /// Neither the object nor the partner can move at these contacts, so that the energy has no limit.
    #[error(
        "contacts {contacts:?}: neither the object, which is anchored, nor the partner can move; strike without partners, or without `anchored`"
    )]
    Immovable {
        /// Indices of the contacts.
        contacts: Vec<usize>,
    },
    /// The energy is not a finite number.
    #[error("the partners bring the energy {0} J, beyond 64-bit numbers; check the units of mass and speed")]
    Energy(f64),
    /// Partners together with the effect `gravity`.
    #[error("the energy of partners leaves out the weight: strike without partners, or without `gravity`")]
    Gravity,
    /// Partners without the effect `elastic`.
    #[error(
        "without the effect `elastic` there is no strain energy that partners could limit: enable it, or strike without partners"
    )]
    Elastic,
    /// Partners in a request for the threshold only.
    #[error("the threshold is a factor on impulses, which partners would limit: ask for it without partners")]
    Threshold,
}
