#!/bin/bash HQ --name=shatter-bake HQ --array=0-7 HQ --cpus=4 Bakes an object in eight shares, one per task of the
#array. Task I bakes share I of SHATTER_SHARDS.
#
#   hq submit --wait --env SHATTER_OUT=$PWD/shares config/hyperqueue/bake.sh MESH NAME 2000
#   config/hyperqueue/merge.sh NAME databases
#
# For another number of shares: hq submit --env SHATTER_SHARDS=16 --array=0-15 ...
#
# If a share fails, submit it again by its number, with the same SHATTER_SHARDS and arguments. It resumes from the examples it
# has:
#
#   hq submit --wait --env SHATTER_OUT=$PWD/shares --array=3 config/hyperqueue/bake.sh MESH NAME 2000
#
# SHATTER_OUT is a folder that all workers share (default: shares). Further arguments are options of `shatterd bake`; all tasks
# must use the same ones. All workers must have the same kind of processor. Others round differently, and `shatterd merge` then
# refuses the shares.
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
