//! `shatter threshold`.

use super::impact::{Host, convention};
use super::{ANSWER, Failure, document, out, reply, vector, with_contact};
use nalgebra::Vector3;
use serde_json::json;
use shatter_client::{Deadline, Impact, Shatter};

/// Arguments of `shatter threshold`.
#[derive(clap::Args)]
pub struct Args {
    /// Object to test.
    object: String,
    /// Contact point in the coordinates of the mesh file, m, or as --convention says.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    point: [f64; 3],
    /// Direction of the impulse; its length does not matter.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    direction: [f64; 3],
    /// Contact duration, s.
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    duration_s: Option<f64>,
    /// Contact radius, m.
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    radius_m: Option<f64>,
    /// Whose coordinates --point, --direction and what is printed are in: axes and unit of length. Other options keep their units.
    #[arg(long, value_name = "gltf|godot|unity|unreal|blender|mujoco", value_parser = convention, default_value = "gltf")]
    convention: Host,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Prints the impulse at which the object just breaks.
pub fn run(service: &str, args: &Args) -> Result<(), Failure> {
    let direction = Vector3::from(args.direction);
    // A direction without length or with a NaN goes out as it is: the service refuses it by name.
    let unit = direction.try_normalize(0.0).filter(|unit| unit.iter().all(|x| x.is_finite())).unwrap_or(direction);
    let host = args.convention.convention;
    let object = Shatter::connect(service, reply())?.with_convention(host).object(&args.object, reply())?;
    let impact = Impact::at(args.point).impulse(unit.into()).threshold_only();
    let impact = with_contact(impact, args.duration_s, args.radius_m.map(|metres| host.length(metres)));
    let broken = object.strike(&impact)?.wait(Deadline::after(ANSWER))?;
    let summary = broken.summary();
    if args.json {
        return document(&json!({
            "object": args.object,
            "convention": args.convention.name,
            "impulse_ns": summary.threshold_impulse_factor,
            "direction": <[f64; 3]>::from(unit),
            "gamma_j_m2": summary.gamma_j_m2,
            "radius_m": summary.radius_m,
        }));
    }
    out(format_args!("{}\n", summary.threshold_impulse_factor))
}
