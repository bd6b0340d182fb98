"""Prints a table of the covered lines: coverage.py SUMMARY."""

import json
import re
import sys
from pathlib import Path

#: Parts of the firmware, and their sources.
PARTS = {
    "application": "firmware/src/application",
    "protections": "firmware/src/protection",
    "drive": "firmware/src/drive",
    "control step": "model-core/src/control",
    "CANopen": "canopen/src",
}

#: The test modules of these parts, and what has no part in a running device: the bootloader's
#: client, text for people, the adapter of a serial line.
OTHERS = re.compile(r"/tests?(/|\.rs)|canopen/src/(slcan|eds)|control/(lanes|cascade/single)")


def lines(files, folder):
    """Covered lines and all lines of the sources whose paths begin with this one."""
    own = [f for f in files if folder in f["filename"] and not OTHERS.search(f["filename"])]
    counts = [f["summary"]["lines"] for f in own]
    return sum(c["covered"] for c in counts), sum(c["count"] for c in counts)


def main():
    files = json.loads(Path(sys.argv[1]).read_text())["data"][0]["files"]
    for name, folder in PARTS.items():
        covered, count = lines(files, folder)
        print(f"{name:14} {100 * covered / count:3.0f} % of {count} lines ({folder})")


main()
