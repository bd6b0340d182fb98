#!/usr/bin/env bash
# Builds the plugin of MuJoCo and tests it in a Python environment with pip's mujoco.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
place=$target/mujoco
export PYTHONDONTWRITEBYTECODE=1
mkdir -p "$place"

say() { printf '\n-- MuJoCo: %s\n' "$*"; }

say "tools"
bash "$root/.ci/environment" "$place/venv" mujoco==4.0.0 numpy pytest matplotlib gymnasium
python=$place/venv/bin/python

say "plugin"
bash build.sh "$python" "$place/libsmart_actuator.so"
export ACTUATOR_PLUGIN=$place/libsmart_actuator.so
export ACTUATOR_LIBRARY=$target/release/libactuator_c.so

export ACTUATOR=$target/debug/actuator
(cd "$root" && bash .ci/programs)

say "tests"
"$python" -m pytest -q -p no:cacheprovider --rootdir tests tests

say "examples"
for example in examples/*.py; do
    "$python" "$example" --out "$place/$(basename "$example" .py).svg"
done

say "a recording to MuJoCo and Gymnasium"
# bindings/python/ci.sh has built the wheel.
"$python" -m pip install --quiet --force-reinstall --no-deps "$target"/python/dist/*.whl
"$ACTUATOR" simulate black-box-2 --input 3-2-1-1 --every 80 --csv "$place/recording.csv" >"$place/simulate.log"
(cd "$place" && MPLBACKEND=Agg "$python" "$root/bindings/python/examples/identify_and_simulate.py" \
    recording.csv "$ACTUATOR_PLUGIN" | tee script.log && grep -E "at most [0-9.]+e-1[0-9] deg off" script.log)

say "the time of a step"
mujoco=$("$python" -c 'import mujoco, os; print(os.path.dirname(mujoco.__file__))')
cc -std=c11 -O2 -Wall -Wextra -Werror -D_POSIX_C_SOURCE=200809L -I "$mujoco/include" benches/step.c "$mujoco"/libmujoco.so.* \
    -Wl,-rpath,"$mujoco" -lm -o "$place/step"
"$place/step" "$ACTUATOR_PLUGIN"
