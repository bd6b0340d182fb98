#!/usr/bin/env bash
# The clients in Python, in the environment of this name.
exec bash "$(dirname "$0")/../../../.ci/environment" "$1" \
    canopen==2.4.1 python-can==4.6.1 pyserial==3.5 dcf-tools==2.4.2
