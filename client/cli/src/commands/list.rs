//! `shatter list`.

use super::{CliError, document, note, objects, out, reply};
use serde_json::{Value, json};
use shatter_client::{Client, ObjectFacts};
use shatter_proto::text::escaped;

/// List the objects of the service, with the bounds of their meshes, or of their lattices if the bake left out the skin or a scene bends
/// them
#[derive(clap::Args)]
pub struct Args {
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

/// Prints the objects of the service.
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    let listed = Client::connect(service, reply())?.objects(reply())?;
    if args.json {
        let listed: Vec<Value> = listed.iter().map(object).collect();
        return document(&json!({ "objects": listed }));
    }
    if listed.is_empty() {
        note(format_args!("the service has no objects; bake one: shatterd bake MESH --name NAME"));
    }
    let width = objects::width(&listed);
    out(format_args!(
        "{:width$}  {:7}  {:BOUNDS$}  {:>11}  {:>11}  {:>6}  material\n",
        "object", "state", "bounds m (low corner, high corner)", "volume m³", "γ J·m²", "nodes"
    ))?;
    for facts in &listed {
        if facts.is_ready() {
            out(format_args!(
                "{:width$}  {:7}  {:BOUNDS$}  {:11.3e}  {:11.3e}  {:6}  {}\n",
                escaped(&facts.name),
                facts.state.name(),
                bounds(facts),
                facts.volume_m3,
                facts.gamma_j_m2,
                facts.crack_nodes,
                facts.material
            ))?;
        }
        out(format_args!("{}", objects::failure_message(facts, width)))?;
    }
    Ok(())
}

/// Width of the column of bounds, characters.
const BOUNDS: usize = 52;

/// Both corners of an object's bounds, as options take points.
fn bounds(facts: &ObjectFacts) -> String {
    let [low, high] = facts.bounds_m.map(|[x, y, z]| [x, y, z].map(coordinate).join(","));
    format!("{low} to {high}")
}

/// A coordinate in tenths of millimeters; with four digits if it is too small for that.
fn coordinate(value: f64) -> String {
    if value != 0.0 && value.abs() < 5e-3 { format!("{value:.3e}") } else { format!("{value:.4}") }
}

fn object(facts: &ObjectFacts) -> Value {
    let more = json!({
        "material": facts.material,
        "bodies": facts.bodies,
        "degree_max": facts.degree_max,
        "fragments_max": facts.fragments_max,
        "bytes_max": facts.bytes_max,
        "elastic_nodes": facts.elastic_nodes,
        "crack_nodes": facts.crack_nodes,
        "gamma_j_m2": facts.gamma_j_m2,
        "young_pa": facts.young_pa,
        "poisson": facts.poisson,
        "density_kg_m3": facts.density_kg_m3,
        "volume_m3": facts.volume_m3,
        "diagonal_m": facts.diagonal_m,
        "center_m": facts.center_m,
        "bounds_m": facts.bounds_m,
        "radius_m": facts.radius_m,
        "duration_s": facts.duration_s,
    });
    objects::document(facts, more)
}
