//! Rays of contacts: aimed at an object whose surface the client does not know.

use super::{Contact, Purpose};
use crate::{Kind, Refusal};

/// The direction as it travels; zero without a ray.
pub(super) fn wire(i: usize, ray: Option<[f64; 3]>) -> Result<[f64; 3], Refusal> {
    match ray {
        None => Ok([0.0; 3]),
        Some(ray) if ray == [0.0; 3] => Err(without_direction(i, "zero")),
        Some(ray) => Ok(ray),
    }
}

/// The direction of contact `i`, if it has a ray.
pub(super) fn direction(i: usize, ray: [f64; 3]) -> Result<Option<[f64; 3]>, Refusal> {
    let square: f64 = ray.iter().map(|x| x * x).sum();
    match square {
        0.0 if ray == [0.0; 3] => Ok(None),
        square if square.is_normal() => Ok(Some(ray)),
        _ => Err(without_direction(i, "not finite, or its square is not")),
    }
}

/// Refuses rays beside other contacts, and aiming without a ray.
pub(super) fn check(contacts: &[Contact], purpose: Purpose) -> Result<(), Refusal> {
    let first = contacts.iter().position(|contact| contact.ray.is_some());
    match first {
        Some(i) if contacts.len() > 1 => {
            let count = contacts.len();
            let message = format!(
                "contact {i} has a ray, but there are {count} contacts; a ray needs a strike of one contact. Aim first, and pass the points."
            );
            Err(Refusal::new(Kind::Ray, format!("contacts[{i}].ray"), message))
        }
        None if purpose == Purpose::Aim => {
            Err(Refusal::new(Kind::Ray, "contacts[0].ray", "contact 0 has no ray; aiming needs one"))
        }
        _ => Ok(()),
    }
}

fn without_direction(i: usize, what: &str) -> Refusal {
    let message = format!("contact {i}: the direction of the ray is {what}; pass a direction of any other length");
    Refusal::new(Kind::Ray, format!("contacts[{i}].ray"), message)
}
