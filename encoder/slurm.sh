#!/bin/bash
# One encode over several machines under Slurm, or many encodes as an array of jobs of one machine each.
#
#   sbatch --nodes=8 slurm.sh scan.zip scan.btf.exr [btf-encode options...]
#   sbatch --array=1-$(grep -vc '^#' all.txt) --nodes=1 slurm.sh all.txt materials [btf-encode options...]
#
# SCRATCH: a folder that all machines share (Lustre, GPFS, NFS), with room for the samples: 12 bytes each texel,
# view and light. A job that was stopped goes on with the same command, with another number of machines too, since
# --resume takes up what is in the checkpoint, if there is one.
#
# SPDX-License-Identifier: MIT
#SBATCH --job-name=btf-encode
#SBATCH --ntasks-per-node=1
#SBATCH --exclusive
#SBATCH --time=08:00:00
#SBATCH --signal=TERM@60
set -eu
input=$1 output=$2
shift 2
export OMP_WAIT_POLICY=passive
if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
    # One line of the list; ranks would only divide what the jobs of the array have already divided.
    exec btf-encode "$input" -o "$output" --item "$SLURM_ARRAY_TASK_ID" --checkpoint "$output.steps" --resume -q "$@"
fi
export TMPDIR=${SCRATCH:?a folder that all machines share}
mkdir -p "$TMPDIR"
# One rank a machine with all of its cores: --bind-to none, or a rank would be given one core.
exec mpirun -n "${SLURM_NNODES:?to be started by sbatch}" --map-by ppr:1:node --bind-to none \
    -x TMPDIR -x OMP_WAIT_POLICY \
    btf-encode "$input" -o "$output" --checkpoint "$output.steps" --resume --report "$output.json" "$@"
