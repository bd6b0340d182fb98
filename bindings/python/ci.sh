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
"$python" -m pip install --quiet pytest "dask[distributed]" mypy pandas openpyxl polars pyarrow scipy gymnasium control "jax[cpu]" \
    jsbsim==1.3.3 "better-actuator-models==1.0.2; python_version >= '3.12'"
ACTUATOR=$target/debug/actuator "$python" -m pytest -q -p no:cacheprovider \
    --rootdir "$source" -c "$source/pyproject.toml" "$source/tests"

say "Newton, which needs a MuJoCo of its own"
bash "$source/../../.ci/environment" "$place/newton" "newton[sim]==1.8.0" pytest
newton=$place/newton/bin/python
"$newton" -m pip install --quiet --force-reinstall --no-deps dist/*.whl
# The tests are skipped where an import fails: this reports it.
"$newton" -c "import newton, mujoco_warp"
"$newton" -m pytest -q -p no:cacheprovider --rootdir "$source" -c "$source/pyproject.toml" \
    "$source/tests/test_export.py" -k newton

say "the table of servos"
"$python" "$source/../../models/table.py" --check "$target/debug/actuator"

say "types"
blocks=$place/blocks
rm -rf "$blocks"
PYTHONPATH=$source/../package "$python" - "$blocks" <<'END'
"""Writes the Python of the documents and of the notebook into files, for the type checker."""

import json
import pathlib
import sys

from documents import BINDINGS, BLOCK, DOCUMENTS, NOTEBOOK

folder = pathlib.Path(sys.argv[1])
folder.mkdir()
for document in DOCUMENTS:
    found = BLOCK.findall((BINDINGS / document).read_text())
    blocks = [block for language, block in found if language == "python"]
    assert blocks, f"{document} has no block of Python"
    for index, block in enumerate(blocks):
        (folder / f"{document.split('/')[0]}_{index}.py").write_text(block)
cells = json.loads(NOTEBOOK.read_text())["cells"]
code = ["".join(cell["source"]) + "\n" for cell in cells if cell["cell_type"] == "code"]
(folder / "notebook.py").write_text("\n".join(code))
END
# Without a configuration, as a reader runs it. Other documents import packages without types.
strict=("$python" -m mypy --strict --config-file= --cache-dir "$place/mypy")
"${strict[@]}" "$blocks"/python_*.py
"${strict[@]}" --disable-error-code=import-untyped --untyped-calls-exclude=distributed \
    "$blocks"/{mujoco,fmu}_*.py "$blocks/notebook.py" "$source"/examples/*.py
"$python" -m mypy --config-file "$source/pyproject.toml" --cache-dir "$place/mypy" -p smart_actuator
# It takes a Literal of several strings for a Union.
"$python" -m mypy.stubtest smart_actuator --ignore-disjoint-bases \
    --allowlist <(echo 'smart_actuator\._choices\..*') --mypy-config-file "$source/pyproject.toml"
