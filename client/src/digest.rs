//! Content hashes of a result: equal for identical results. Times and the handle do not count.

use crate::FractureResult;
use shatter_proto::result::{EffectWire, SectionKind, StageWire, SummaryWire};

/// Hash of one section.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SectionDigest {
    /// Name of the section.
    pub name: &'static str,
    /// Its length in bytes.
    pub bytes: u64,
    /// 16 hexadecimal digits of BLAKE3 (O'Connor, Aumasson, Neves & Wilcox-O'Hearn 2020).
    pub hash: String,
}

/// Hashes of a result.
#[derive(Clone, Debug, PartialEq, Eq)]
#[must_use]
#[non_exhaustive]
pub struct ResultDigest {
    /// By section, in the order of the result; without the sections of effects that are off.
    pub sections: Vec<SectionDigest>,
    /// Hash of all sections together.
    pub output_hash: String,
}

impl FractureResult {
    /// Hashes the result. Equal requests on equal databases give equal hashes, whatever the number of threads.
    pub fn digest(&self) -> ResultDigest {
        let view = self.raw_view();
        let timeless: Vec<StageWire> = view.stages.iter().map(|stage| StageWire { ns: 0, ..*stage }).collect();
        let timeless_effects: Vec<EffectWire> = view.effects.iter().map(|row| EffectWire { ns: 0, ..*row }).collect();
        let nameless = SummaryWire { handle: 0, time_ns: 0, overrun: 0, overrun_ns: 0, ..*view.summary };
        let mut all = blake3::Hasher::new();
        let sections = SectionKind::ALL
            .into_iter()
            .filter_map(|kind| {
                let bytes: &[u8] = match kind {
                    SectionKind::Summary => bytemuck::bytes_of(&nameless),
                    SectionKind::Stages => bytemuck::cast_slice(&timeless),
                    SectionKind::Effects => bytemuck::cast_slice(&timeless_effects),
                    kind => view.bytes(kind),
                };
                if kind.effect().is_some() && bytes.is_empty() {
                    return None;
                }
                all.update(kind.name().as_bytes());
                all.update(&(bytes.len() as u64).to_le_bytes());
                all.update(bytes);
                Some(SectionDigest { name: kind.name(), bytes: bytes.len() as u64, hash: short(blake3::hash(bytes)) })
            })
            .collect();
        ResultDigest { sections, output_hash: short(all.finalize()) }
    }
}

fn short(hash: blake3::Hash) -> String {
    hash.to_hex()[..16].to_owned()
}
