#!/usr/bin/env bash
# Fuzzes the readers from the stored corpus: tests/fuzz.sh [--minutes N] [--target NAME] [--merge]. Called by ./run fuzz, which builds first.
# An input that breaks a promise (tests/fuzz/targets.hpp), crashes, hangs for 10 s or takes 2 GB ends the run with code 1 and is kept in
# out/fuzz. --merge takes what reached new code into tests/fuzz/corpus, as few and as short inputs as reach the same.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bin=${FUZZ_BIN:-build/fuzz/bin}
minutes=12 only= merge=0
while [ $# -gt 0 ]; do
  case $1 in
    --minutes) minutes=${2:?--minutes N}; shift 2 ;;
    --target) only=${2:?--target NAME}; shift 2 ;;
    --merge) merge=1; shift ;;
    *) echo "fuzz: no option '$1'; there are --minutes N, --target NAME, --merge" >&2; exit 2 ;;
  esac
done

# Share of the time: the case file has the most to find, the table the least.
declare -A share=([case_file]=45 [state_file]=25 [point_path]=15 [campaign_plan]=10 [csv_table]=5)
export OMP_NUM_THREADS=1 OMP_WAIT_POLICY=passive
export ASAN_OPTIONS=allocator_may_return_null=0:detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
code=0
mkdir -p out/fuzz
# Words of case files and point paths: the names and choices in the files whose components declare keys.
{ cat tests/fuzz/toml.dict; grep -rlE 'void declare|SchemaOf<' libmpm | xargs grep -hoE '"[a-z][a-z_0-9.]*"' | sort -u; } >out/fuzz/toml.dict
for target in ${only:-case_file state_file point_path campaign_plan csv_table}; do
  [ -x "$bin/fuzz_$target" ] || { echo "fuzz: no program $bin/fuzz_$target" >&2; exit 2; }
  seconds=$(( minutes * 60 * ( ${only:+100} + 0 ) / 100 ))
  [ -n "$only" ] || seconds=$(( minutes * 60 * ${share[$target]} / 100 ))
  new=out/fuzz/$target
  mkdir -p "$new"
  options=(-rss_limit_mb=2048 -malloc_limit_mb=1024 -timeout=10 -max_total_time="$seconds" -print_final_stats=1 -artifact_prefix="out/fuzz/$target-")
  case $target in
    case_file | point_path | campaign_plan) options+=(-dict=out/fuzz/toml.dict -max_len=4096) ;;
    csv_table) options+=(-max_len=1024) ;;
    state_file) options+=(-max_len=64) ;;
  esac
  echo "== $target for $seconds s"
  "$bin/fuzz_$target" "${options[@]}" "$new" "tests/fuzz/corpus/$target" >"out/fuzz/$target.log" 2>&1 || code=1
  grep -E '^#[0-9]+.*(INITED|DONE)|^stat::(number_of_executed_units|average_exec_per_sec|peak_rss_mb)|^SUMMARY|terminating|what\(\)|Test unit written' "out/fuzz/$target.log" || true
  if [ $merge -eq 1 ]; then
    rm -rf "out/fuzz/$target.merged"
    mkdir -p "out/fuzz/$target.merged"
    "$bin/fuzz_$target" -merge=1 -timeout=10 "out/fuzz/$target.merged" "tests/fuzz/corpus/$target" "$new" >"out/fuzz/$target.merge.log" 2>&1
    echo "merged: $(ls "out/fuzz/$target.merged" | wc -l) inputs, $(du -sb "out/fuzz/$target.merged" | cut -f1) bytes, in out/fuzz/$target.merged"
  fi
done
[ $code -eq 0 ] || echo "fuzz: a finding is in out/fuzz; replay it with $bin/fuzz_<target> FILE" >&2
exit $code
