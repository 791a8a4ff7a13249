#!/usr/bin/env bash
# A run of hours: memory flat, no particle lost. What is asserted and why: soak.py.
exec /usr/bin/python3 "$(dirname "${BASH_SOURCE[0]}")/soak.py" "$@"
