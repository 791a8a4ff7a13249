#!/usr/bin/env bash
# Makes the tables of evidence in results/ again from the rows that are kept here; their first line names the commit. Needs a tree without
# changes, so commit new rows first. `./run study` then draws the page.
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
evaluate "$study/results/coarse/results.csv" --width "$study/evidence/width/results.csv" --sections "$study/evidence/sections/results.csv" \
  --sensitivity "$study/evidence/sensitivity/results.csv" --friction "$study/evidence/friction_015/results.csv" \
  --friction-scan "$study/evidence/friction_w5/results.csv" \
  --prediction "$study/results/prediction/w5.csv" --grids "$study/evidence/grids/results.csv" \
  --grids "$study/evidence/grids/settled.csv"
evaluate "$study/results/fine/results.csv" --sensitivity "$study/evidence/transfer/results.csv"
evaluate "$study/results/prediction/w5.csv" "$study/results/prediction/w7.csv" --join --finest --name prediction
evaluate "$study/results/reproduction/w5.csv" --join --name reproduction
for campaign in prediction reproduction; do
  cp "$made/$campaign/fit.json" "$study/results/$campaign/"
  for table in "$made/$campaign"/*.csv; do
    if [ "$(wc -l < "$table")" -gt 1 ]; then cp "$table" "$study/results/$campaign/"; fi
  done
done
for campaign in coarse fine; do
  for table in "$made/$campaign"/*.csv; do
    if head -1 "$table" | grep -q '^# computed by'; then cp "$table" "$study/results/$campaign/"; fi
  done
done
