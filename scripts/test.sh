#!/usr/bin/env bash
# The tests, all but the long fuzzing; arguments go to pytest. Set-up: make ready-test
set -euo pipefail
cd "$(dirname "$0")/.."
exec .venv/bin/python -m pytest -n "${JOBS:-2}" --dist worksteal -m "not fuzz" "$@"
