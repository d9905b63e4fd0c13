//! Bodies that strike the object, whose energy limits that of an impact.

use super::{Contact, ContactWire};
use crate::text::number;
use crate::{Error, ErrorKind};

/// Body that strikes the object at a contact, and how fast. Lengths and axes are those of the request's convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPartner {
    /// Its number: contacts with the same number have the same partner, whose energy counts once.
    pub id: u64,
    /// Mass, kg; infinite: it does not move.
    pub mass_kg: f64,
    /// Closing speed of partner and object along the impulse, m/s; negative where they separate.
    pub speed_m_s: f64,
    /// Center of mass, m; of no effect without inertia.
    pub center_m: [f64; 3],
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz, as of fragments. Zero: it does not rotate.
    pub inertia_kg_m2: [f64; 6],
}

impl ContactPartner {
    /// A partner that does not rotate.
    #[must_use]
    pub fn new(id: u64, mass_kg: f64, speed_m_s: f64) -> Self {
        Self { id, mass_kg, speed_m_s, center_m: [0.0; 3], inertia_kg_m2: [0.0; 6] }
    }

    /// The same partner, which may rotate about its center.
    #[must_use]
    pub fn rotating(self, center_m: [f64; 3], inertia_kg_m2: [f64; 6]) -> Self {
        Self { center_m, inertia_kg_m2, ..self }
    }

    /// Writes the partner of contact `i`.
    ///
    /// # Errors
    /// `contact_partner` for a mass of zero, which stands for no partner.
    pub(super) fn write(&self, i: usize, wire: &mut ContactWire) -> Result<(), Error> {
        if self.mass_kg == 0.0 {
            return Err(mass(i, 0.0));
        }
        (wire.partner, wire.partner_mass_kg, wire.speed_m_s) = (self.id, self.mass_kg, self.speed_m_s);
        (wire.partner_center_m, wire.partner_inertia_kg_m2) = (self.center_m, self.inertia_kg_m2);
        Ok(())
    }

    /// The partner of contact `i`; `None` without one.
    ///
    /// # Errors
    /// `contact_partner`.
    pub(super) fn read(i: usize, wire: &ContactWire) -> Result<Option<Self>, Error> {
        let own = Self {
            id: wire.partner,
            mass_kg: wire.partner_mass_kg,
            speed_m_s: wire.speed_m_s,
            center_m: wire.partner_center_m,
            inertia_kg_m2: wire.partner_inertia_kg_m2,
        };
        if own.mass_kg == 0.0 {
            let without = Self::new(0, 0.0, 0.0);
            return if own == without { Ok(None) } else { Err(mass(i, 0.0)) };
        }
        if own.mass_kg.is_nan() || own.mass_kg < 0.0 {
            return Err(mass(i, own.mass_kg));
        }
        let fields = [
            ("speed_m_s", "the closing speed", std::slice::from_ref(&own.speed_m_s)),
            ("partner_center_m", "the center of the partner", &own.center_m),
            ("partner_inertia_kg_m2", "the inertia of the partner", &own.inertia_kg_m2),
        ];
        for (field, name, values) in fields {
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(refused(i, field, &format!("{name} must be finite, got {}", number(*value))));
            }
        }
        if !own.can_have_inertia() {
            let message = "the inertia of the partner must be positive definite, or zero if it does not rotate";
            return Err(refused(i, "partner_inertia_kg_m2", message));
        }
        Ok(Some(own))
    }

    /// Whether the inertia is zero or positive definite (criterion of J. J. Sylvester, by leading minors).
    fn can_have_inertia(&self) -> bool {
        let [xx, yy, zz, xy, xz, yz] = self.inertia_kg_m2;
        let second = xx * yy - xy * xy;
        let third = zz * second - xx * yz * yz + 2.0 * xy * xz * yz - yy * xz * xz;
        self.inertia_kg_m2 == [0.0; 6] || (xx > 0.0 && second > 0.0 && third > 0.0)
    }

    /// Field of the first property in which `other` differs; speeds may differ.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        match () {
            () if self.mass_kg != other.mass_kg => Some("partner_mass_kg"),
            () if self.center_m != other.center_m => Some("partner_center_m"),
            () if self.inertia_kg_m2 != other.inertia_kg_m2 => Some("partner_inertia_kg_m2"),
            () => None,
        }
    }
}

/// Checks that all contacts have a partner or none has, and that the same partner has the same properties everywhere.
///
/// # Errors
/// `contact_partner`.
pub(super) fn check(contacts: &[Contact]) -> Result<(), Error> {
    if contacts.iter().all(|contact| contact.partner.is_none()) {
        return Ok(());
    }
    for (i, contact) in contacts.iter().enumerate() {
        let Some(own) = contact.partner else {
            let message = "it has no partner, but another contact has one; give a partner for all contacts or for none";
            return Err(refused(i, "partner_mass_kg", message));
        };
        let earlier = contacts[..i].iter().enumerate().filter_map(|(j, contact)| Some((j, contact.partner?)));
        for (j, other) in earlier.filter(|(_, other)| other.id == own.id) {
            if let Some(field) = own.difference(&other) {
                let message = format!("its partner {} is that of contact {j}, but {field} differs", own.id);
                return Err(refused(i, field, &message));
            }
        }
    }
    Ok(())
}

fn mass(i: usize, value: f64) -> Error {
    let message = format!("the mass of the partner must be above zero, and may be infinite; got {}", number(value));
    refused(i, "partner_mass_kg", &message)
}

fn refused(i: usize, field: &str, message: &str) -> Error {
    Error::new(ErrorKind::ContactPartner, format!("contacts[{i}].{field}"), format!("contact {i}: {message}"))
}
