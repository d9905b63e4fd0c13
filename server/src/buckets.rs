//! How large the buckets are that results are lent in.

use crate::catalog::Catalog;
use crate::config::Config;
use crate::ipc::PoolSize;
use shatter_proto::result::BLOCK_BYTES;

const MIB: usize = 1024 * 1024;

/// Smallest bucket: objects that are baked while the daemon serves find room for their answers, too. What is not written takes no memory.
const BUCKET_MIN_BYTES: usize = 16 * MIB;

/// Buckets as large as the largest answer of the loaded objects needs. They cost nothing until they are written.
pub(crate) fn size(config: &Config, catalog: &Catalog) -> PoolSize {
    let bytes = catalog.answer_bytes_max().max(BUCKET_MIN_BYTES).min(config.answers.bucket_mib_max * MIB);
    PoolSize {
        clients: config.service.clients_max,
        buckets: config.answers.buckets,
        blocks: bytes.div_ceil(BLOCK_BYTES),
    }
}

/// Whether answers want larger buckets than there are, and larger ones than was `told` before. A restart makes no larger ones than the
/// configuration allows, so no more than that is wanted.
pub(crate) fn is_short(wanted: u64, bucket_bytes: u64, told: &mut u64) -> bool {
    let short = wanted > bucket_bytes.max(*told);
    if short {
        *told = wanted;
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_buckets_are_asked_for_once_and_only_where_a_restart_makes_them() {
        let (bucket_bytes, mut told) = (100, 0);
        let asked = [90, 150, 120, 150, 200, 200].map(|wanted| is_short(wanted, bucket_bytes, &mut told));
        assert_eq!(asked, [false, true, false, false, true, false]);
    }
}
