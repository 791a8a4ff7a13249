#!/usr/bin/env bash
# Makes the tables of evidence in results/ again from the rows that are kept here; their first line names the commit. Needs a tree without
# changes, so commit new rows first. Fills the tables of the texts from them, too. `./run study` then draws the page.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
git diff --quiet HEAD || {
  echo "evaluate.sh: the tree has changes; commit them first, so that the tables name a commit" >&2
  exit 2
}
study=validation/study
made=$(mktemp -d)
trap 'rm -r "$made"' EXIT
evaluate() { PYTHONPATH=python /usr/bin/python3 -m mpmtools study "$@" --out "$made" --no-page; }
rows=$study/results evidence=$study/evidence
evaluate "$rows/reproduction_w7/w7.csv" --coarser "$rows/reproduction_w5/w5.csv" --prediction "$rows/prediction/w7.csv" \
  --width "$evidence/width/results.csv" --sections "$evidence/sections/results.csv" \
  --sensitivity "$evidence/sensitivity/results.csv" --sensitivity "$evidence/windows/results.csv" \
  --friction-scan "$evidence/friction_w7/results.csv" --friction-scan "$evidence/friction_w7/slow.csv" \
  --friction-scan "$evidence/friction_w7/stiff.csv"
evaluate "$rows/reproduction_w5/w5.csv" --friction-scan "$evidence/friction_w5/results.csv" \
  --prediction "$rows/prediction/w5.csv" --prediction "$rows/calibrated_prediction/w5.csv" \
  --grids "$evidence/grids/results.csv" --grids "$evidence/grids/settled.csv"
evaluate "$rows/prediction/w5.csv" "$rows/prediction/w7.csv" --join --finest --name prediction
evaluate "$rows/prediction/w5.csv" "$rows/prediction/w7.csv" "$rows/calibrated_prediction/w5.csv" --join --replace \
  --filter 'hardening_xi!=0.05' --name calibrated_prediction
evaluate "$rows/first_w5/results.csv" --friction "$evidence/friction_015/results.csv" --sensitivity "$evidence/sensitivity/results.csv"
evaluate "$rows/first_w7/results.csv" --sensitivity "$evidence/transfer/results.csv"
for campaign in "$made"/*; do
  for file in "$campaign"/*; do
    kept=$rows/$(basename "$campaign")/$(basename "$file")
    case $kept in */first_*) [ -f "$kept" ] || continue ;; esac        # of the first reproduction only the tables that the texts use
    if [ "$(wc -l <"$file")" -gt 1 ]; then cp "$file" "$kept"; fi # what needs the folders of the runs is empty here
  done
done
"$study/fill_tables.py"
