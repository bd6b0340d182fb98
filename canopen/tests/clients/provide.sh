#!/usr/bin/env bash
# Installs the clients in Python in the environment of this name, unless they are there. Several
# checks may ask at the same time.
set -euo pipefail
venv=$1
mkdir -p "$(dirname "$venv")"
exec 9>"$venv.lock"
flock 9
[ -x "$venv/bin/pip" ] || python3 -m venv "$venv"
[ -x "$venv/bin/dcfchk" ] && "$venv/bin/python" -c 'import canopen, can, serial' 2>/dev/null ||
    "$venv/bin/pip" install --quiet --disable-pip-version-check \
        canopen==2.4.1 python-can==4.6.1 pyserial==3.5 dcf-tools==2.4.2
