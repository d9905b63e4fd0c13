//! Check of contact radii against the size of the object.

use shatter_fracture::pipeline::{FractureRequest, PreparedObject};
use shatter_fracture::scene::{DEFAULT_RADIUS_DIAGONALS, EffectKind};
use shatter_proto::{Error, ErrorKind};

/// Rounding of a radius that was converted from another unit, as a share of it.
const ROUNDING: f64 = 1e-9;

/// Refuses a contact that is larger than the object. Without the effect `elastic` any radius is possible: a very large one makes fragments
/// of equal size.
pub(super) fn check(prepared: &PreparedObject, request: &FractureRequest) -> Result<(), Error> {
    let diagonal_m = prepared.frame.diagonal_m;
    let is_larger = |radius_m: f64| radius_m.is_finite() && radius_m > diagonal_m * (1.0 + ROUNDING);
    let radii = request.contacts.iter().map(|contact| contact.radius_m);
    let larger = radii.enumerate().find_map(|(contact, radius_m)| Some((contact, radius_m.filter(|r| is_larger(*r))?)));
    let Some((contact, radius_m)) = larger.filter(|_| request.effects.has(EffectKind::Elastic)) else { return Ok(()) };
    let default_m = DEFAULT_RADIUS_DIAGONALS * diagonal_m;
    let [radius, diagonal, default] = [radius_m, diagonal_m, default_m].map(length);
    // Where four decimals show no difference, all are shown.
    let [radius, diagonal] =
        if radius == diagonal { [radius_m, diagonal_m].map(|x| x.to_string()) } else { [radius, diagonal] };
    let message = format!(
        "contact {contact}: the radius of {radius} m is larger than the object, whose bounding box has a diagonal of {diagonal} m; \
         give a smaller radius, or none for the default of {default} m"
    );
    Err(Error::new(ErrorKind::ContactRadius, format!("contacts[{contact}].radius_m"), message))
}

/// A length with four decimals, or in exponent form where these show nothing or too much.
fn length(length_m: f64) -> String {
    if (1e-4..=1e9).contains(&length_m) { format!("{length_m:.4}") } else { format!("{length_m:.4e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn very_small_and_very_large_lengths_have_an_exponent() {
        assert_eq!([0.25, 1e308, 2e-5].map(length), ["0.2500", "1.0000e308", "2.0000e-5"]);
    }
}
