#!/usr/bin/env bash
# The whole suite on two cores: one process drives browsers, which mostly wait, and two take the
# other tests, which mostly compute.
# With arguments it is one ordinary run of pytest with them.
set -euo pipefail
cd "$(dirname "$0")/.."
if (($#)); then exec .venv/bin/pytest "$@"; fi

said=$(mktemp)
trap 'rm -f "$said"' EXIT
.venv/bin/pytest -m browser >"$said" 2>&1 &
browsers=$!
status=0
.venv/bin/pytest -m "not browser" -n 2 --dist worksteal || status=$?
echo "The tests in real browsers, run meanwhile:"
wait "$browsers" || status=$?
cat "$said"
exit "$status"
