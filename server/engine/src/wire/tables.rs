//! Check that the tables which a request needs are loaded, with advice on how to get missing ones.

use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{FractureRequest, PreparedBody, PreparedObject};
use shatter_fracture::scene::EffectKind;
use shatter_proto::{Error, ErrorKind};

/// Refuses a request that needs a missing table of `prepared`, before anything is computed.
pub(super) fn check(prepared: &PreparedObject, strike: &FractureRequest) -> Result<(), Error> {
    let lacks = |has: &dyn Fn(&PreparedBody) -> bool| prepared.bodies.iter().any(|body| !has(body));
    let wants = |effect| strike.effects.has(effect);
    if wants(EffectKind::Elastic) && lacks(&|body| body.solid.is_some()) {
        return Err(effect(prepared, EffectKind::Elastic));
    }
    if strike.threshold_only {
        return Ok(());
    }
    let lifted = |body| strike.lift_of(prepared, body).is_ok();
    if wants(EffectKind::Interior) && !(0..prepared.bodies.len()).all(lifted) {
        return Err(lift(prepared, strike.lift));
    }
    if wants(EffectKind::Attributes) && lacks(&|body| body.outer.is_some()) {
        return Err(effect(prepared, EffectKind::Attributes));
    }
    if wants(EffectKind::Skin) && prepared.skin.is_none() {
        return Err(effect(prepared, EffectKind::Skin));
    }
    Ok(())
}

/// Error for an effect whose table is missing. Tables have the names of their effects.
fn effect(prepared: &PreparedObject, effect: EffectKind) -> Error {
    let (object, name) = (&prepared.name, effect.name());
    let message = format!(
        "`{object}` has no table `{name}`: strike with --disable {name}, or add \"{name}\" to `effects` or `allow` of [objects.{object}] \
         in its scene, and bake it again by `shatterd bake` if its database has none either"
    );
    Error::new(ErrorKind::Effect, name, message)
}

/// Error for a missing lift.
fn lift(prepared: &PreparedObject, lift: LiftKind) -> Error {
    let object = &prepared.name;
    let failed = prepared.report.unprepared.iter().find(|failed| failed.lift == lift);
    let message = match failed {
        Some(failed) => format!(
            "`{object}` has no lift `{lift}`: the bake could not make it for body {} ({}); strike with another --lift",
            failed.body, failed.reason
        ),
        None => format!(
            "`{object}` has no lift `{lift}`: strike with another --lift, or set lift = \"{lift}\" in [objects.{object}] of its scene, and \
             bake it again by `shatterd bake` if its database has none either"
        ),
    };
    Error::new(ErrorKind::Lift, lift.to_string(), message)
}
