#!/usr/bin/env bash
# Makes the wheel, installs it in a clean environment without Rust, and tests it there. Needs Python
# 3 with venv and access to the package index.
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

say "clean environment without Rust"
rm -rf "$place/clean"
python3 -m venv "$place/clean"
python=$place/clean/bin/python
without_rust=$place/clean/bin:/usr/bin:/bin
if PATH=$without_rust command -v rustc cargo; then
    echo "there is a Rust in /usr/bin: it is not used, but could be" >&2
fi

say "example of the README"
# So that `dist` is that of the README, and the installed package is imported.
cd "$place"
readme() { sed -n "/^\`\`\`$1\$/,/^\`\`\`\$/p" "$source/README.md" | sed '/^```/d'; }
readme sh >install.sh
grep -qx 'pip install dist/\*.whl' install.sh
env -i HOME="$HOME" PATH="$without_rust" PIP_QUIET=1 bash -e install.sh
readme python >example.py
env -i HOME="$HOME" PATH="$without_rust" python example.py

say "tests"
"$python" -m pip install --quiet pytest "dask[distributed]" mypy pandas polars pyarrow scipy gymnasium control "jax[cpu]" \
    mujoco==4.0.0 jsbsim==1.3.3 "better-actuator-models==1.0.2; python_version >= '3.12'" matplotlib nbclient ipykernel
bash "$source/../../.ci/programs"
ACTUATOR=$target/debug/actuator "$python" -m pytest -q -p no:cacheprovider \
    --rootdir "$source" -c "$source/pyproject.toml" "$source/tests"

say "the table of servos"
"$python" "$source/../../models/table.py" --check "$target/debug/actuator"

say "notebook"
PATH=$place/clean/bin:$PATH MPLBACKEND=Agg "$python" -c "
import nbclient, nbformat, sys
book = nbformat.read(sys.argv[1], as_version=4)
nbclient.NotebookClient(book, timeout=300).execute()
print(len(book.cells), 'cells')
" "$source/examples/from_paper_to_simulator.ipynb"

say "types"
"$python" -m mypy --config-file "$source/pyproject.toml" --cache-dir "$place/mypy" -p smart_actuator
# It takes a Literal of several strings for a Union.
"$python" -m mypy.stubtest smart_actuator --ignore-disjoint-bases \
    --allowlist <(echo 'smart_actuator\._choices\..*') --mypy-config-file "$source/pyproject.toml"
