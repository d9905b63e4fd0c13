//! `shatter threshold`.

use super::impact::{energy_error, hit};
use super::parse::{NamedConvention, convention, criterion, lift, origin, quality, ray, vector};
use super::result_text::{has_weight, hit_line};
use super::{CliError, RESULT_TIMEOUT, document, out, reply, with_options};
use nalgebra::Vector3;
use serde_json::json;
use shatter_client::{Client, Contact, Deadline, Impact, Lift, Quality, Ray, RequestedCriterion, RetainedFragment};
use shatter_proto::request::squarable;

/// Arguments of `shatter threshold`.
#[derive(clap::Args)]
pub struct Args {
    /// Object to test
    object: String,
    /// Contact point in the coordinates of the object, m: those of the mesh file after --unit and --up of `bake`, +Y up. Or in those of
    /// --convention
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, required_unless_present = "ray")]
    point: Option<[f64; 3]>,
    /// Ray instead of a point: the contact point is the first hit on the object from X,Y,Z along DX,DY,DZ
    #[arg(long, value_name = "X,Y,Z,DX,DY,DZ", value_parser = ray, allow_hyphen_values = true, conflicts_with = "point")]
    ray: Option<Ray>,
    /// Direction of the impulse, of any length [default with --ray: that of the ray]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, required_unless_present = "ray")]
    direction: Option<[f64; 3]>,
    /// Contact duration, s [default: the object's]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    duration_s: Option<f64>,
    /// Contact radius, m [default: the object's]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    radius_m: Option<f64>,
    /// Threshold γ, J·m² [default: the object's]
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    gamma: Option<f64>,
    /// Rule that decides whether the object breaks: `paper`, by the threshold γ, or `strength`, by strength and energy [default: the object's]
    #[arg(long, value_name = "paper|strength", value_parser = criterion)]
    criterion: Option<RequestedCriterion>,
    /// Lift: `euclidean`, `interior` (the default) or `surface_diffusion`
    #[arg(long, value_name = "euclidean|interior|surface_diffusion", value_parser = lift)]
    lift: Option<Lift>,
    /// Preset that sets how the displacements are computed [default: the object's]
    #[arg(long, value_name = "draft|game|film|reference", value_parser = quality)]
    quality: Option<Quality>,
    /// Fragment of a kept result to test, instead of the object
    #[arg(long, value_name = "HANDLE/FRAGMENT", value_parser = origin)]
    from: Option<RetainedFragment>,
    /// Coordinates of --point, --direction and the output: axes and unit of length. Other options keep their units
    #[arg(long, value_name = "gltf|godot|unity|unreal|blender|mujoco", value_parser = convention, default_value = "gltf")]
    convention: NamedConvention,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

/// The direction, of length one; `None` if it is zero or not finite.
fn unit(direction: [f64; 3]) -> Option<Vector3<f64>> {
    Vector3::from(squarable(direction)).try_normalize(0.0).filter(|unit| unit.iter().all(|x| x.is_finite()))
}

/// Request for the threshold of `contact`.
fn test(contact: Contact, args: &Args) -> Impact {
    let impact = Impact::new([contact]).threshold_only();
    let impact = args.gamma.map_or(impact.clone(), |gamma| impact.gamma(gamma));
    let impact = args.quality.map_or(impact.clone(), |quality| impact.quality(quality));
    let impact = args.lift.map_or(impact.clone(), |lift| impact.lift(lift));
    let impact = args.criterion.map_or(impact.clone(), |criterion| impact.criterion(criterion));
    args.from.map_or(impact.clone(), |from| impact.from(from.handle, from.fragment))
}

/// Prints the impulse that just breaks the object.
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    let along = args.ray.map_or([0.0; 3], |ray| ray.direction);
    let unit = unit(args.direction.unwrap_or(along)).ok_or_else(|| {
        let (option, whose) = if args.direction.is_some() {
            ("--direction", "direction")
        } else {
            ("--ray", "direction DX,DY,DZ of the ray")
        };
        CliError::Usage(format!("{option}: the {whose} is zero or not finite; pass one of any other length"))
    })?;
    let host = args.convention.convention;
    let object = Client::connect(service, reply())?.with_convention(host).object(&args.object, reply())?;
    let contact = args.ray.map_or_else(|| Contact::new(args.point.unwrap_or_default()), Contact::from);
    let radius = args.radius_m.map(|meters| host.length(meters));
    let struck = |impulse_ns: f64| {
        let contact = with_options(contact.impulse((impulse_ns * unit).into()), args.duration_s, radius);
        object.strike(&test(contact, args))?.wait(Deadline::after(RESULT_TIMEOUT))
    };
    let result = struck(1.0)?;
    let summary = result.summary();
    if args.json {
        let strain_j = match summary.threshold_impulse_factor {
            // Its weight alone breaks it.
            0.0 => None,
            // The energy of impulse and weight together is not proportional to the square of the impulse.
            just if has_weight(&result) => struck(just)?.summary().strain_j,
            just => summary.strain_j.map(|strain_j| strain_j * just * just),
        };
        return document(&json!({
            "object": args.object,
            "convention": args.convention.name,
            "impulse_ns": summary.threshold_impulse_factor,
            "direction": <[f64; 3]>::from(unit),
            "criterion": summary.criterion.name(),
            "gamma_j_m2": summary.gamma_j_m2,
            "radius_m": summary.radius_m,
            "ledger": { "strain_j": strain_j },
            "elastic": summary.energy_source.name(),
            "error_estimate": {
                "energy": energy_error(&summary),
                "discretisation_error": summary.discretization_error,
            },
            "hit": result.hit().map(hit),
        }));
    }
    result.hit().map_or(Ok(()), |hit| out(format_args!("{}\n", hit_line(&hit))))?;
    let unit = if host.meters_per_unit == 1.0 {
        "N·s".to_owned()
    } else {
        format!("kg·unit/s (unit: {} m)", host.meters_per_unit)
    };
    out(format_args!("{} {unit}\n", exact(summary.threshold_impulse_factor)))
}

/// All digits of a number, with a power of ten where it would be long.
fn exact(value: f64) -> String {
    if value == 0.0 || (1e-4..1e15).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::exact;

    #[test]
    fn impulses_keep_their_digits_and_stay_short() {
        assert_eq!([0.0, 0.1 + 0.2, 12_345.5].map(exact), ["0", "0.30000000000000004", "12345.5"]);
        assert_eq!([1.25e-7, 6.5e149, f64::INFINITY].map(exact), ["1.25e-7", "6.5e149", "inf"]);
    }
}
