//! Merging of contacts that are near each other.

use super::{CONTACTS_MAX, ContactBody, ContactError, HertzContact};
use nalgebra::Vector3;

/// One contact of one step, as a simulator reports it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactEvent {
    /// Contact point, m, in the coordinates of the object (those of its mesh file).
    pub point_m: [f64; 3],
    /// Impulse on the object, N·s, in the same coordinates.
    pub impulse_ns: [f64; 3],
    /// Approach speed of the bodies at the point before the step, along the normal, m/s.
    pub speed_m_s: f64,
    /// The body that touched the object.
    pub other: ContactBody,
}

/// One contact of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergedContact {
    /// Contact point, m.
    pub point_m: [f64; 3],
    /// Impulse on the object, N·s.
    pub impulse_ns: [f64; 3],
    /// Approach speed of the bodies, m/s.
    pub speed_m_s: f64,
    /// Duration and radius of the contact, with the quantities of the theory.
    pub hertz: HertzContact,
}

/// Largest share of the impulse that merging the contacts of a step may lose.
///
/// Contacts of one face share a normal: friction between them costs a few percent of the sum. More than half is lost only
/// where contacts have no Hertz theory (a plane lands on a plane) or cancel each other.
pub const LOSS_MAX: f64 = 0.5;

/// Error for contacts whose impulses would be lost: the body is not struck.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the contacts of this step have {given_ns} N·s, of which an impact would keep {kept_ns} N·s: {}. Give the body a finite radius (ContactPolicy::radius), merge fewer contacts (ContactPolicy::merge), or set duration and radius of the contacts yourself",
    self.reason()
)]
pub struct ImpulseLost {
    /// Sum of the magnitudes of the impulses of the step, N·s.
    pub given_ns: f64,
    /// Sum of the magnitudes of the impulses that would be kept, N·s.
    pub kept_ns: f64,
    /// Reason why the strongest lost contact has no duration and radius; `None` if all have them, and the contacts cancel each other.
    pub cause: Option<ContactError>,
}

impl ImpulseLost {
    fn reason(&self) -> String {
        self.cause.map_or_else(|| "merged contacts cancel each other".to_owned(), |cause| cause.to_string())
    }
}

/// A group of merged contacts: sums, and means weighted by the magnitudes of impulses.
#[derive(Clone, Copy)]
pub(super) struct ContactGroup {
    point: Vector3<f64>,
    impulse: Vector3<f64>,
    speed_m_s: f64,
    /// Sum of the magnitudes of its impulses, N·s.
    weight: f64,
    /// The other body of the strongest contact, and the magnitude of that contact's impulse.
    other: ContactBody,
    strongest: f64,
}

impl ContactGroup {
    /// A group of one contact; `None` without an impulse, or if a number of it is not finite.
    pub fn of(touch: &ContactEvent) -> Option<Self> {
        let (point, impulse) = (Vector3::from(touch.point_m), Vector3::from(touch.impulse_ns));
        let weight = impulse.norm();
        let sound = weight > 0.0 && weight.is_finite() && point.iter().all(|x| x.is_finite());
        let speed_m_s = touch.speed_m_s;
        (sound && speed_m_s.is_finite()).then_some(Self {
            point,
            impulse,
            speed_m_s,
            weight,
            other: touch.other,
            strongest: weight,
        })
    }

    /// Sum of the magnitudes of its impulses, N·s.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Distance from the other group, m.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        (self.point - other.point).norm()
    }

    pub(super) fn with(&self, next: &Self) -> Self {
        let weight = self.weight + next.weight;
        let share = next.weight / weight;
        let leads = next.strongest > self.strongest;
        Self {
            point: self.point.lerp(&next.point, share),
            impulse: self.impulse + next.impulse,
            speed_m_s: self.speed_m_s + share * (next.speed_m_s - self.speed_m_s),
            weight,
            other: if leads { next.other } else { self.other },
            strongest: self.strongest.max(next.strongest),
        }
    }

    /// The group as a contact of an impact on `own`; `None` if its impulses cancel.
    ///
    /// # Errors
    /// The theory has no solution for it.
    fn merged_contact(&self, own: &ContactBody) -> Result<Option<MergedContact>, ContactError> {
        let impulse_ns = self.impulse.norm();
        if impulse_ns == 0.0 {
            return Ok(None);
        }
        let hertz = HertzContact::of_impulse(own, &self.other, self.speed_m_s, impulse_ns)?;
        let (point_m, impulse_ns) = (self.point.into(), self.impulse.into());
        Ok(Some(MergedContact { point_m, impulse_ns, speed_m_s: self.speed_m_s, hertz }))
    }
}

/// Contacts of an impact on `own`. The nearest two groups merge while they are nearer than `merge_m`, or while there are more than
/// [`CONTACTS_MAX`]. The strongest comes first; the order of `groups` changes only the last bits.
///
/// # Errors
/// More than [`LOSS_MAX`] of the impulse would be lost.
pub(super) fn merged(
    mut groups: Vec<ContactGroup>,
    own: &ContactBody,
    merge_m: f64,
) -> Result<Vec<MergedContact>, ImpulseLost> {
    let given_ns: f64 = groups.iter().map(ContactGroup::weight).sum();
    while let Some((i, j, distance)) = nearest(&groups) {
        if distance >= merge_m && groups.len() <= CONTACTS_MAX {
            break;
        }
        groups[i] = groups[i].with(&groups[j]);
        groups.swap_remove(j);
    }
    groups.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let (mut merged_contacts, mut cause) = (Vec::new(), None);
    for group in &groups {
        match group.merged_contact(own) {
            Ok(merged_contact) => merged_contacts.extend(merged_contact),
            Err(error) => cause = cause.or(Some(error)),
        }
    }
    let kept_ns: f64 =
        merged_contacts.iter().map(|merged_contact| Vector3::from(merged_contact.impulse_ns).norm()).sum();
    if kept_ns < (1.0 - LOSS_MAX) * given_ns {
        return Err(ImpulseLost { given_ns, kept_ns, cause });
    }
    Ok(merged_contacts)
}

/// The two groups nearest to each other, and their distance, m.
fn nearest(groups: &[ContactGroup]) -> Option<(usize, usize, f64)> {
    let pairs = (0..groups.len()).flat_map(|i| (i + 1..groups.len()).map(move |j| (i, j)));
    let apart = |(i, j): (usize, usize)| (i, j, groups[i].distance(&groups[j]));
    pairs.map(apart).min_by(|a, b| a.2.total_cmp(&b.2))
}
