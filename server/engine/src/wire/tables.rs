//! Which tables of a database a strike needs, and how to get one that was left out.

use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{Body, Prepared, Strike};
use shatter_fracture::scene::Effect;
use shatter_proto::{Kind, Refusal};

/// Refuses a strike that needs a table which `prepared` does not have, before anything is computed.
pub(super) fn check(prepared: &Prepared, strike: &Strike) -> Result<(), Refusal> {
    let lacks = |has: &dyn Fn(&Body) -> bool| prepared.bodies.iter().any(|body| !has(body));
    let wants = |effect| strike.effects.has(effect);
    if wants(Effect::Elastic) && lacks(&|body| body.solid.is_some()) {
        return Err(effect(prepared, Effect::Elastic));
    }
    if strike.threshold_only {
        return Ok(());
    }
    let lifted = |body| prepared.lift_for(body, strike).is_ok();
    if wants(Effect::Interior) && !(0..prepared.bodies.len()).all(lifted) {
        return Err(lift(prepared, strike.lift));
    }
    if wants(Effect::Attributes) && lacks(&|body| body.outer.is_some()) {
        return Err(effect(prepared, Effect::Attributes));
    }
    if wants(Effect::Skin) && prepared.skin.is_none() {
        return Err(effect(prepared, Effect::Skin));
    }
    Ok(())
}

/// The refusal of an effect whose table is missing. Tables have the names of their effects.
fn effect(prepared: &Prepared, effect: Effect) -> Refusal {
    let (object, name) = (&prepared.name, effect.name());
    let message = format!(
        "`{object}` has no table `{name}`, which the effect `{name}` needs: add \"{name}\" to `effects` or `allow` of \
         [objects.{object}] in its scene and run `shatterd bake --scene` again (`shatterd bake MESH` makes every table), or strike \
         with --disable {name}"
    );
    Refusal::new(Kind::Effect, name, message)
}

/// The refusal of a lift that is missing.
fn lift(prepared: &Prepared, lift: LiftKind) -> Refusal {
    let object = &prepared.name;
    let failed = prepared.report.unprepared.iter().find(|failed| failed.lift == lift);
    let message = match failed {
        Some(failed) => format!(
            "`{object}` has no lift `{lift}`: the bake could not make it for body {} ({}); strike with another --lift",
            failed.body, failed.reason
        ),
        None => format!(
            "`{object}` has no lift `{lift}`: set lift = \"{lift}\" in [objects.{object}] of its scene and run `shatterd bake --scene` \
             again (`shatterd bake MESH` makes every lift), or strike with another --lift"
        ),
    };
    Refusal::new(Kind::Lift, lift.to_string(), message)
}
