//! A result as one binary message.
//!
//! Layout, little-endian: four bytes with the length of the head, the head as JSON, spaces up to a multiple of eight, then the
//! sections. Each section lies at a multiple of eight bytes from the beginning of the message. The head names the sections that are not
//! empty, with `offset` and `bytes`.

use serde_json::{Value, json};
use shatter_client::{EffectCost, EnergySource, FractureResult, Quality, SectionDigest, StageCost};
use shatter_proto::result::SectionKind;

/// Alignment of sections: that of the widest number.
const ALIGNMENT: usize = 8;

/// A binary message to the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResultMessage(Vec<u8>);

impl ResultMessage {
    /// The message of a result of an object of `material`, in reply to request `id`. With `has_hashes`, its head has the hashes of the
    /// sections; they take longer than all else here.
    #[must_use]
    pub fn of_result(id: u64, result: &FractureResult, material: &str, has_hashes: bool) -> Self {
        let view = result.raw_view();
        let sections: Vec<(&str, &[u8])> = SectionKind::ALL
            .into_iter()
            .map(|kind| (kind.name(), view.bytes(kind)))
            .filter(|(_, bytes)| !bytes.is_empty())
            .collect();
        let mut head = facts(result);
        head["id"] = json!(id);
        head["reply"] = json!("result");
        head["material"] = json!(material);
        if has_hashes {
            let digest = result.digest();
            let row = |own: &SectionDigest| json!({ "name": own.name, "hash": own.hash });
            head["hashes"] = digest.sections.iter().map(row).collect();
            head["output_hash"] = json!(digest.output_hash);
        }
        Self::new(head, &sections)
    }

    /// The message of any named byte arrays.
    #[must_use]
    pub fn new(mut head: Value, sections: &[(&str, &[u8])]) -> Self {
        // The offsets are counted from the end of the head, whose length depends on its digits otherwise.
        let mut offset = 0;
        let rows: Vec<Value> = sections
            .iter()
            .map(|(name, bytes)| {
                let row = json!({ "name": name, "offset": offset, "bytes": bytes.len() });
                offset += bytes.len().next_multiple_of(ALIGNMENT);
                row
            })
            .collect();
        head["sections"] = Value::Array(rows);
        let mut head = head.to_string();
        head.push_str(&" ".repeat((4 + head.len()).next_multiple_of(ALIGNMENT) - 4 - head.len()));
        let mut message = Vec::with_capacity(4 + head.len() + offset);
        message.extend((head.len() as u32).to_le_bytes());
        message.extend(head.as_bytes());
        for (_, bytes) in sections {
            message.extend_from_slice(bytes);
            message.resize(message.len().next_multiple_of(ALIGNMENT), 0);
        }
        Self(message)
    }

    /// Its bytes.
    #[must_use]
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// Facts of a result, as the page shows them.
fn facts(result: &FractureResult) -> Value {
    let summary = result.summary();
    let nanoseconds = |time: std::time::Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
    let stage =
        |cost: StageCost| json!({ "name": cost.stage.name(), "ran": cost.has_run, "ns": nanoseconds(cost.time) });
    let effect =
        |cost: EffectCost| json!({ "name": cost.effect.name(), "ran": cost.has_run, "ns": nanoseconds(cost.time) });
    let is_elastic = ![EnergySource::Falloff, EnergySource::Bounded].contains(&summary.energy_source);
    let hit =
        result.hit().map(|hit| json!({ "point_m": hit.point_m, "normal": hit.normal, "distance_m": hit.distance_m }));
    json!({
        "object": summary.object,
        "handle": result.handle().map(|handle| handle.to_string()),
        "sites": summary.sites,
        "fracture_degree": summary.fracture_degree,
        "degree_source": summary.degree_origin.name(),
        "confidence": summary.confidence,
        "capped": summary.is_capped,
        "stop_reason": summary.stop_criterion.name(),
        "elastic": summary.energy_source.name(),
        "quality": summary.quality.map(Quality::name),
        "gamma_j_m2": summary.gamma_j_m2,
        "e1_over_gamma": summary.e1_over_gamma,
        "threshold_factor": summary.threshold_impulse_factor,
        "strain_j": summary.strain_j,
        "impactor_j": summary.impactor_j,
        "surface_j": summary.surface_j,
        "released_j": summary.released_j,
        "stress_over_strength": summary.stress_over_strength,
        "seed": summary.seed.to_string(),
        "radius_m": summary.radius_m,
        "energy_error": is_elastic.then_some(summary.energy_error),
        "cvd_gap": (summary.sites > 0).then_some(summary.cvd_gap),
        "iterations": summary.iterations,
        "surface": summary.surface.name(),
        "time_ns": nanoseconds(summary.time),
        "round_trip_ns": nanoseconds(result.round_trip()),
        "response_bytes": result.bytes(),
        "hit": hit,
        "stages": result.stages().map(stage).collect::<Vec<_>>(),
        "effects": result.effects().map(effect).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_lie_at_multiples_of_eight_bytes() {
        for name in ["a", "ab", "abc", "abcd", "abcde", "abcdef", "abcdefg", "abcdefgh"] {
            let sections: [(&str, &[u8]); 2] = [(name, &[1, 2, 3]), ("other", &[4; 9])];
            let bytes = ResultMessage::new(json!({"id": 7}), &sections).into_bytes();
            let head_bytes = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
            let head: Value = serde_json::from_slice(&bytes[4..4 + head_bytes]).unwrap();
            let first = 4 + head_bytes;
            assert_eq!((first % 8, head["id"].as_u64()), (0, Some(7)));
            let at = |i: usize| first + head["sections"][i]["offset"].as_u64().unwrap() as usize;
            assert_eq!((at(0) % 8, at(1) % 8, &bytes[at(0)..at(0) + 3]), (0, 0, &[1u8, 2, 3][..]));
            assert_eq!(&bytes[at(1)..at(1) + 9], [4; 9]);
        }
    }
}
