//! `shatter list`.

use super::{Failure, document, objects, out, reply};
use serde_json::{Value, json};
use shatter_client::{ObjectFacts, Shatter};

/// Arguments of `shatter list`.
#[derive(clap::Args)]
pub struct Args {
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// Lists the objects of the service.
pub fn run(service: &str, args: &Args) -> Result<(), Failure> {
    let listed = Shatter::connect(service, reply())?.objects(reply())?;
    if args.json {
        let listed: Vec<Value> = listed.iter().map(object).collect();
        return document(&json!({ "objects": listed }));
    }
    let width = objects::width(&listed);
    out(format_args!(
        "{:width$}  {:>8}  {:>11}  {:>11}  {:>6}  material\n",
        "object", "size m", "volume m³", "γ J·m²", "nodes"
    ))?;
    for facts in &listed {
        if facts.ready {
            out(format_args!(
                "{:width$}  {:8.3}  {:11.3e}  {:11.3e}  {:6}  {}\n",
                facts.name, facts.diagonal_m, facts.volume_m3, facts.gamma_j_m2, facts.crack_nodes, facts.material
            ))?;
        }
        out(format_args!("{}", objects::complaint(facts, width)))?;
    }
    Ok(())
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
        "centre_m": facts.centre_m,
        "radius_m": facts.radius_m,
        "duration_s": facts.duration_s,
    });
    objects::document(facts, more)
}
