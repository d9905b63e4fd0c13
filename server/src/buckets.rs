//! Size of the shared-memory buckets for results.

use crate::catalog::Catalog;
use crate::config::Config;
use crate::ipc::PoolSize;
use shatter_proto::Error;
use shatter_proto::result::BLOCK_BYTES;
use shatter_transport::workarounds::few_descriptors;

const MIB: usize = 1024 * 1024;

/// Smallest bucket: also holds results of objects that are baked while the daemon serves. Unwritten memory costs nothing.
const BUCKET_MIN_BYTES: usize = 16 * MIB;

/// Blocks of a bucket for the largest result of the loaded objects. Unwritten memory costs nothing.
pub(crate) fn blocks(config: &Config, catalog: &Catalog) -> usize {
    let bytes = catalog.result_bytes_max().max(BUCKET_MIN_BYTES).min(config.results.bucket_mib_max * MIB);
    bytes.div_ceil(BLOCK_BYTES)
}

/// Pool with such buckets, for as many clients as the limit of descriptors suffices for.
///
/// # Errors
/// `configuration` if it suffices for none.
pub(crate) fn size(config: &Config, catalog: &Catalog) -> Result<PoolSize, Error> {
    let clients = few_descriptors::clients(config.service.clients_max)?;
    Ok(PoolSize { clients, buckets: config.results.buckets, blocks: blocks(config, catalog) })
}

/// Whether results need larger buckets than exist, and larger ones than the last warning (`reported`, bytes) asked for.
///
/// `wanted` must not exceed the configured maximum, since a restart makes no larger buckets.
pub(crate) fn is_short(wanted: u64, bucket_bytes: u64, reported: &mut u64) -> bool {
    let short = wanted > bucket_bytes.max(*reported);
    if short {
        *reported = wanted;
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_buckets_are_asked_for_once_and_only_where_a_restart_makes_them() {
        let (bucket_bytes, mut reported) = (100, 0);
        let asked = [90, 150, 120, 150, 200, 200].map(|wanted| is_short(wanted, bucket_bytes, &mut reported));
        assert_eq!(asked, [false, true, false, false, true, false]);
    }
}
