#!/usr/bin/env bash
# Trace files as others read them: Octave, scipy and pyarrow against the CSV of the same run, bit
# for bit. Installs what it needs: Octave by apt where it is not there, Python's packages below
# target/. With --parquet the Parquet files too: building their crate takes some minutes.
set -euo pipefail
features=()
[ "${1:-}" != --parquet ] || features=(--features parquet)
cd "$(dirname "$0")/../../.."
tests=$PWD/host-sim/tests/files
python=$PWD/target/files-venv/bin/python
runs=$PWD/target/files-runs

bash .ci/provide octave-cli octave
bash .ci/environment target/files-venv numpy==2.4.6 scipy==1.17.1 pyarrow==26.0.1

if [ -z "${features[*]}" ]; then
    bash .ci/programs
else
    cargo clippy -p host-sim -p actuator "${features[@]}" --all-targets --locked -- -D warnings
    # Builds the program too.
    cargo test -p host-sim -p actuator "${features[@]}" --locked trace_file
fi

compare() {
    local files=("$runs/run.mat")
    [ -z "${features[*]}" ] || files+=("$runs/run.parquet")
    target/debug/actuator simulate "$@" --csv "$runs/run.csv" "${files[@]/#/--out=}" >"$runs/summary.txt"
    "$python" "$tests/compare.py" "$runs/run.csv" "${files[@]}"
    octave-cli --no-gui --no-init-file "$tests/compare.m" "$runs/run.csv" "$runs/run.mat"
}
mkdir -p "$runs"
# One row; all columns there are; more rows than a format gathers before it writes.
compare board --duration 1e-9
compare board --plant bench --set encoder_noise_deg=0.03 --input 3-2-1-1
compare board --input chirp --every 1 --duration 15
