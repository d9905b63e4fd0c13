//! Rays of contacts: they aim at an object whose surface the client does not know.

use super::{Contact, Purpose};
use crate::{Error, ErrorKind};

/// The direction as it travels; zero without a ray.
pub(super) fn wire(i: usize, ray: Option<[f64; 3]>) -> Result<[f64; 3], Error> {
    match ray {
        None => Ok([0.0; 3]),
        Some(ray) if ray == [0.0; 3] => Err(without_direction(i, "zero")),
        Some(ray) => Ok(ray),
    }
}

/// The direction of contact `i`, if it has a ray.
pub(super) fn direction(i: usize, ray: [f64; 3]) -> Result<Option<[f64; 3]>, Error> {
    match ray {
        [0.0, 0.0, 0.0] => Ok(None),
        ray if ray.iter().all(|x| x.is_finite()) => Ok(Some(ray)),
        _ => Err(without_direction(i, "not finite")),
    }
}

/// `direction`, or where the square of its length overflows or vanishes the same direction in a length that can be squared. Zero and what is not
/// finite stay as they are.
pub fn squarable(direction: [f64; 3]) -> [f64; 3] {
    let square: f64 = direction.iter().map(|x| x * x).sum();
    let largest = direction.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let possible = largest > 0.0 && direction.iter().all(|x| x.is_finite());
    if square.is_normal() || !possible { direction } else { direction.map(|x| x / largest) }
}

/// Checks that a ray stands alone, and that a request that aims has one.
///
/// # Errors
/// `ray`.
pub(super) fn check(contacts: &[Contact], purpose: Purpose) -> Result<(), Error> {
    let first = contacts.iter().position(|contact| contact.ray.is_some());
    match first {
        Some(i) if contacts.len() > 1 => {
            let count = contacts.len();
            let message = format!(
                "contact {i} has a ray, but there are {count} contacts; a ray needs a request of one contact. Aim first, and pass the points."
            );
            Err(Error::new(ErrorKind::Ray, format!("contacts[{i}].ray"), message))
        }
        None if purpose == Purpose::Aim => {
            Err(Error::new(ErrorKind::Ray, "contacts[0].ray", "contact 0 has no ray; aiming needs one"))
        }
        _ => Ok(()),
    }
}

fn without_direction(i: usize, what: &str) -> Error {
    let message = format!("contact {i}: the direction of the ray is {what}; pass a direction of any other length");
    Error::new(ErrorKind::Ray, format!("contacts[{i}].ray"), message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_any_length_can_be_squared() {
        for (given, wanted) in [
            ([3.0, -4.0, 0.0], [3.0, -4.0, 0.0]),
            ([0.0, -1e300, 1e300], [0.0, -1.0, 1.0]),
            ([5e-324, 0.0, 0.0], [1.0, 0.0, 0.0]),
            ([0.0, 2e-300, 1e-300], [0.0, 1.0, 0.5]),
            ([0.0; 3], [0.0; 3]),
        ] {
            assert_eq!(squarable(given), wanted);
        }
        assert_eq!(squarable([f64::INFINITY, 0.0, 1.0])[0], f64::INFINITY);
        assert!(direction(0, [1e300, 0.0, 0.0]).is_ok() && direction(0, [f64::NAN, 0.0, 0.0]).is_err());
    }
}
