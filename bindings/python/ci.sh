#!/usr/bin/env bash
# Builds the wheel, installs it in a clean environment and tests it there. Needs Python 3 with venv
# and access to the package index.
set -euo pipefail
cd "$(dirname "$0")"
source=$PWD
target=$(cd ../.. && pwd)/target
place=$target/python
mkdir -p "$place"
export PYTHONDONTWRITEBYTECODE=1

say() { printf '\n-- %s\n' "$*"; }

say "tools"
[ -x "$place/tools/bin/maturin" ] || python3 -m venv "$place/tools"
"$place/tools/bin/pip" install --quiet "maturin>=1.9.4,<2"

say "wheel"
rm -rf "$place/wheels"
CARGO_TARGET_DIR=$target "$place/tools/bin/maturin" build --quiet --locked --out "$place/wheels"

say "clean environment"
rm -rf "$place/clean"
python3 -m venv "$place/clean"
python=$place/clean/bin/python
"$python" -m pip install --quiet "$place"/wheels/*.whl

say "example of the README"
cd "$place" # so that the installed package is imported
"$python" - <(sed -n '/^```python$/,/^```$/p' "$source/README.md" | sed '/^```/d') <<'CODE'
import sys
code = open(sys.argv[1]).read()
assert len(code.splitlines()) == 5, code
exec(compile(code, "README.md", "exec"))
CODE

say "tests"
"$python" -m pip install --quiet pytest "dask[distributed]" mypy pandas polars pyarrow
bash "$source/../../.ci/programs"
ACTUATOR=$target/debug/actuator "$python" -m pytest -q -p no:cacheprovider \
    --rootdir "$source" -c "$source/pyproject.toml" "$source/tests"

say "types"
"$python" -m mypy --config-file "$source/pyproject.toml" --cache-dir "$place/mypy" -p smart_actuator
"$python" -m mypy.stubtest smart_actuator --ignore-disjoint-bases --mypy-config-file "$source/pyproject.toml"
