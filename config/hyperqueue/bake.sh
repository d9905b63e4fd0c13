#!/bin/bash
#HQ --name=shatter-bake
#HQ --array=0-7
#HQ --cpus=4
# Bakes one object in eight shares, one per task of the array: task I bakes share I of SHATTER_SHARDS.
#
#   hq submit --wait --env SHATTER_OUT=$PWD/shares config/hyperqueue/bake.sh MESH NAME 2000
#   config/hyperqueue/merge.sh NAME databases
#
# Other numbers of shares: hq submit --env SHATTER_SHARDS=16 --array=0-15 ...
#
# Submit a share that failed again by its number, with everything else as before, SHATTER_SHARDS too. It goes on with what it has:
#
#   hq submit --wait --env SHATTER_OUT=$PWD/shares --array=3 config/hyperqueue/bake.sh MESH NAME 2000
#
# SHATTER_OUT is a folder that all workers see (default: shares). Further arguments are flags of `shatterd bake`; they must be the
# same for all tasks. All workers must have one kind of processor: others round differently, and `shatterd merge` then refuses the
# shares.
set -euo pipefail
mesh=$1 name=$2 examples=$3
shift 3
out=${SHATTER_OUT:-shares}
mkdir -p "$out"
# HQ_CPUS lists the processors of the task: 3,2,7.
cpus=${HQ_CPUS:-0}
IFS=, read -r -a cpus <<<"$cpus"
export RAYON_NUM_THREADS=${#cpus[@]}
exec shatterd bake "$mesh" --name "$name" --examples "$examples" --out "$out" --shard "$HQ_TASK_ID/${SHATTER_SHARDS:-8}" --resume "$@"
