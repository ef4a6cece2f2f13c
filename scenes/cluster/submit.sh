#!/bin/sh
# Gives a run to Slurm: an array of shares, and a merge once all of them are there.
#
#   SCENE=scenes/office.json OUT=out/office SHARES=8 CHAINS=1e7 TARGET=0.3% scenes/cluster/submit.sh
#
# Eight shares do not meet the target, and the merge says that five more would? FIRST=9 SHARES=13 computes the others and merges all.
set -eu
here=$(dirname "$0")
: "${SCENE:?}" "${OUT:?}" "${SHARES:?}" "${CHAINS:?}" "${TARGET:?}"
export SCENE OUT SHARES CHAINS TARGET

shares=$(sbatch --parsable --array="${FIRST:-1}-$SHARES" "$here/share.sh")
sbatch --dependency="afterok:$shares" "$here/merge.sh"
