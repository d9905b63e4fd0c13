#!/bin/bash
# Joins the shares that bake.sh wrote: config/hyperqueue/merge.sh NAME [FOLDER], or the same under `hq submit --cpus=4`.
set -euo pipefail
exec shatterd merge "${SHATTER_OUT:-shares}/$1".*-of-"${SHATTER_SHARDS:-8}".share --out "${2:-databases}"
