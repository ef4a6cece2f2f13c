#!/bin/sh
# One share of a run: a task of a Slurm job array, or a pod of a Kubernetes job with indexes.
#
# SCENE    scene file
# OUT      directory for all results; shares go to OUT/shares/1, OUT/shares/2, …
# SHARES   how many there are
# CHAINS   chains of each share
# TARGET   what the merged result is judged by, such as 0.3%
# OPTIONS  further options of luxmc solve, if any
#
# A task that is ended or killed, and requeued, goes on from its checkpoint in OUT/checkpoints: results are the same bytes as without.
#
#SBATCH --job-name=luxmc-share
#SBATCH --cpus-per-task=2
#SBATCH --time=04:00:00
#SBATCH --requeue
set -eu

# Slurm counts the tasks from 1, as submit.sh asks for; Kubernetes counts from 0.
number=${SLURM_ARRAY_TASK_ID:-$((${JOB_COMPLETION_INDEX:?no number of a share} + 1))}
threads=${SLURM_CPUS_PER_TASK:-${THREADS:-2}}

# A checkpoint that is there is that of a task which has not ended.
checkpoint=$OUT/checkpoints/$number.ckpt
mkdir -p "$OUT/checkpoints"
if [ -s "$checkpoint" ]; then
    luxmc resume "$checkpoint" --scene "$SCENE" --out "$OUT/shares/$number" --threads "$threads" --quiet
else
    # shellcheck disable=SC2086 # options are words
    luxmc solve "$SCENE" --out "$OUT/shares/$number" --share "$number/$SHARES" --chains "$CHAINS" --target-error "$TARGET" \
        --checkpoint "$checkpoint" --threads "$threads" --plots none --quiet ${OPTIONS:-}
fi
rm -f "$checkpoint"
