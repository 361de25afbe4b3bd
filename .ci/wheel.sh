#!/usr/bin/env bash
# Builds a Python wheel that carries the program:  .ci/wheel.sh [FOLDER [MATURIN ARGUMENTS]]   (default: target/wheels)
# Needs maturin (`pip install maturin`). `pip install FOLDER/loopscope-….whl` then puts `loopscope` beside `python`.
set -euo pipefail
cd "$(dirname "$0")/.."

out=${1:-target/wheels}
shift || true
mkdir -p "$out"
out=$(cd "$out" && pwd)
# Without a pyproject.toml at the top level, maturin looks for the crate where that file says.
work=$(mktemp -d -p .)
trap 'rm -rf "$PWD/$work"' EXIT
cp .ci/pyproject.toml README.md LICENSE-MIT LICENSE-APACHE "$work"
cp assets/licences.txt "$work/LICENCES-OF-CRATES.txt"
echo 'manifest-path = "../Cargo.toml"' >>"$work/pyproject.toml"
(cd "$work" && maturin build --release --locked --out "$out" "$@")
