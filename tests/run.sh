#!/usr/bin/env bash
# The whole suite as two processes side by side: browsers mostly wait, the other tests mostly compute.
# With arguments it is one ordinary run of pytest with them.
set -euo pipefail
cd "$(dirname "$0")/.."
if (($#)); then exec .venv/bin/pytest "$@"; fi

said=$(mktemp)
trap 'rm -f "$said"' EXIT
.venv/bin/pytest -m browser >"$said" 2>&1 &
browsers=$!
status=0
.venv/bin/pytest -m "not browser" || status=$?
echo "The tests in real browsers, run meanwhile:"
wait "$browsers" || status=$?
cat "$said"
exit "$status"
