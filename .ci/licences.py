#!/usr/bin/env python3
"""Fails if the licence of a dependency is not compatible with MIT OR Apache-2.0.

Of this workspace, or of that of another manifest.
"""
import json
import re
import subprocess
import sys

ALLOWED = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause",
    "BSL-1.0", "CC0-1.0", "ISC", "MIT", "MIT-0", "Unicode-3.0", "Unlicense", "Zlib",
}

# Tools of the tests that are not part of any build product, with their licences.
TOOLS = {"alterable_logger": "MPL-2.0", "cbindgen": "MPL-2.0", "colored": "MPL-2.0"}


def allowed(expression):
    """Whether an SPDX expression can be met; old crates write `/` for OR."""
    python = re.sub(
        r"\(|\)|\bAND\b|\bOR\b|/|[A-Za-z0-9.+-]+( WITH [A-Za-z0-9.+-]+)?",
        lambda m: {"AND": " and ", "OR": " or ", "/": " or ", "(": "(", ")": ")"}.get(
            m[0], str(m[0] in ALLOWED)),
        expression,
    )
    if not re.fullmatch(r"(True|False|and|or|[() ])+", python):
        return False
    return eval(python)


def main():
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    command += [f"--manifest-path={path}" for path in sys.argv[1:]]
    packages = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["packages"]
    refused = [
        f"{p['name']} {p['version']}: {p['license'] or 'no licence named'}"
        for p in packages
        if not allowed(p["license"] or "") and TOOLS.get(p["name"]) != p["license"]
    ]
    print(f"{len(packages)} packages, {len(refused)} refused")
    print("\n".join(refused))
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
