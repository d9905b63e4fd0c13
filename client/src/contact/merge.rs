//! Contacts near each other are one.

use super::{CONTACTS_MAX, Hertz, Partner};
use nalgebra::Vector3;

/// One contact of one step, as a simulator has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Where, m, in the coordinates of the object (those of its mesh file).
    pub point_m: [f64; 3],
    /// What it handed to the object, N·s, in the same coordinates.
    pub impulse_ns: [f64; 3],
    /// How fast the bodies approached each other there before the step, m/s, along the normal.
    pub speed_m_s: f64,
    /// What touched it.
    pub other: Partner,
}

/// One contact of a strike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blow {
    /// Where, m.
    pub point_m: [f64; 3],
    /// What it hands to the object, N·s.
    pub impulse_ns: [f64; 3],
    /// How fast the bodies met, m/s.
    pub speed_m_s: f64,
    /// Its duration and radius, and what follows from them.
    pub hertz: Hertz,
}

/// Contacts that became one: sums and means weighted by the sizes of impulses.
#[derive(Clone, Copy)]
pub(super) struct Group {
    point: Vector3<f64>,
    impulse: Vector3<f64>,
    speed_m_s: f64,
    /// Sum of the sizes of its impulses, N·s.
    weight: f64,
    /// The strongest contact's, and how strong that was.
    other: Partner,
    strongest: f64,
}

impl Group {
    /// A contact by itself; `None` without an impulse, and if a figure of it is not finite.
    pub fn of(touch: &Touch) -> Option<Self> {
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

    /// Sum of the sizes of its impulses, N·s.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    fn with(&self, next: &Self) -> Self {
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

    /// The contact of a strike that it is for `own`; `None` where its impulses cancel, or theory has no answer.
    fn blow(&self, own: &Partner) -> Option<Blow> {
        let hertz = Hertz::of_impulse(own, &self.other, self.speed_m_s, self.impulse.norm()).ok()?;
        let (point_m, impulse_ns) = (self.point.into(), self.impulse.into());
        Some(Blow { point_m, impulse_ns, speed_m_s: self.speed_m_s, hertz })
    }
}

/// Contacts of a strike of `own`: the nearest two become one for as long as they are nearer than `merge_m`, or there are too many
/// ([`CONTACTS_MAX`]). Strongest first; the same for any order of `groups`, but for the last bits.
pub(super) fn merged(mut groups: Vec<Group>, own: &Partner, merge_m: f64) -> Vec<Blow> {
    while let Some((i, j, distance)) = nearest(&groups) {
        if distance >= merge_m && groups.len() <= CONTACTS_MAX {
            break;
        }
        groups[i] = groups[i].with(&groups[j]);
        groups.swap_remove(j);
    }
    groups.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    groups.iter().filter_map(|group| group.blow(own)).collect()
}

/// The two groups nearest to each other, and how far they are apart, m.
fn nearest(groups: &[Group]) -> Option<(usize, usize, f64)> {
    let pairs = (0..groups.len()).flat_map(|i| (i + 1..groups.len()).map(move |j| (i, j)));
    let apart = |(i, j): (usize, usize)| (i, j, (groups[i].point - groups[j].point).norm());
    pairs.map(apart).min_by(|a, b| a.2.total_cmp(&b.2))
}
