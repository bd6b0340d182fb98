#!/usr/bin/env bash
# Makes the wheel, runs the documents with it in a clean environment without Rust, and tests it
# there.
# Needs Python 3 with venv and access to the package index.
set -euo pipefail
cd "$(dirname "$0")"
source=$PWD
target=$(cd ../.. && pwd)/target
place=$target/python
mkdir -p "$place"
export PYTHONDONTWRITEBYTECODE=1

say() { printf '\n-- %s\n' "$*"; }

say "wheel"
(cd ../.. && cargo run --quiet --release --locked --bin package -- --out "$place/dist" wheel)
ls -l "$place"/dist/*.whl

say "the documents in a clean environment without Rust"
bash "$source/../../.ci/programs"
python3 ../package/documents.py "$place/dist" "$target/debug/actuator" "$place"
python=$place/clean/bin/python
cd "$place"

say "tests"
"$python" -m pip install --quiet pytest "dask[distributed]" mypy pandas polars pyarrow scipy gymnasium control "jax[cpu]" \
    jsbsim==1.3.3 "better-actuator-models==1.0.2; python_version >= '3.12'"
ACTUATOR=$target/debug/actuator "$python" -m pytest -q -p no:cacheprovider \
    --rootdir "$source" -c "$source/pyproject.toml" "$source/tests"

say "the table of servos"
"$python" "$source/../../models/table.py" --check "$target/debug/actuator"

say "types"
"$python" -m mypy --config-file "$source/pyproject.toml" --cache-dir "$place/mypy" -p smart_actuator
# It takes a Literal of several strings for a Union.
"$python" -m mypy.stubtest smart_actuator --ignore-disjoint-bases \
    --allowlist <(echo 'smart_actuator\._choices\..*') --mypy-config-file "$source/pyproject.toml"
