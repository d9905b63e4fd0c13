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
    let message = format!(
        "contact {contact}: the radius of {radius_m:.4} m is larger than the object, whose bounding box has a diagonal of \
         {diagonal_m:.4} m; give a smaller radius, or none for the default of {default_m:.4} m"
    );
    Err(Error::new(ErrorKind::ContactRadius, format!("contacts[{contact}].radius_m"), message))
}
