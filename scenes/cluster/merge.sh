#!/bin/sh
# Merges the shares in OUT/shares into OUT/merged, and judges the target. Exit code 3: it is not met; the last lines and "merged" in
# OUT/merged/summary.json tell how many more shares would do.
#
#SBATCH --job-name=luxmc-merge
#SBATCH --cpus-per-task=2
#SBATCH --time=01:00:00
set -eu

luxmc merge "$OUT"/shares/* --out "$OUT/merged"
