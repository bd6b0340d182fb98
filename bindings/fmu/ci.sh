#!/usr/bin/env bash
# The FMUs in FMPy. Needs python3 with venv, and installs FMPy below target/.
set -euo pipefail
cd "$(dirname "$0")/../.."

target=${CARGO_TARGET_DIR:-target}
venv=$target/venv-fmu
bash .ci/environment "$venv" fmpy==0.3.32 numpy

bash .ci/programs
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
for options in "--model black-box-1" "--model black-box-2" "--model grey-box" "--model board" "--plant bench"; do
    # shellcheck disable=SC2086
    for version in 2 3; do
        "$target/debug/actuator" fmu $options --fmi $version --out "$folder/actuator.fmu"
        "$venv/bin/fmpy" validate "$folder/actuator.fmu"
    done
done
ACTUATOR=$(realpath "$target/debug/actuator") "$venv/bin/python" bindings/fmu/tests/test_fmpy.py

# The library for Windows, where the cross compiler is there. It is linked, not run.
if rustup target list --installed | grep -q x86_64-pc-windows-gnu && command -v x86_64-w64-mingw32-gcc > /dev/null; then
    cargo build --locked -p actuator-fmu --target x86_64-pc-windows-gnu
    "$target/debug/actuator" fmu --out "$folder/both.fmu" \
        --library "$target/debug/deps/libactuator_fmu.so" \
        --library "$target/x86_64-pc-windows-gnu/debug/actuator_fmu.dll"
    "$venv/bin/fmpy" validate "$folder/both.fmu"
fi
