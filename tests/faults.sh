#!/usr/bin/env bash
# What may happen to a run, done to runs on purpose: kills, signals, full disks, damaged checkpoints. What is expected: faults.py.
exec /usr/bin/python3 "$(dirname "${BASH_SOURCE[0]}")/faults.py" "$@"
