#!/usr/bin/env bash
# Builds the package as pip does, in a fresh virtual environment, and runs all of its tests against the program of this source tree.
set -euo pipefail
cd "$(dirname "$0")"
home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
python3 -m venv "$home/venv"
"$home/venv/bin/pip" install --quiet ".[test]"
(cd .. && cargo build --release --locked)
(cd tests && LUXMC="${LUXMC:-$PWD/../../target/release/luxmc}" "$home/venv/bin/python" -m pytest -q)
"$home/venv/bin/mypy" --cache-dir "$home/mypy"
