#!/usr/bin/env python3
"""Fails if docs/conformance.md names a test that does not exist."""
import pathlib
import re
import sys

sources = "".join(
    path.read_text()
    for folder in ("canopen/src", "canopen/tests", "firmware/src", "firmware/tests", "tests/board")
    for suffix in ("*.rs", "*.py", "*.js")
    for path in sorted(pathlib.Path(folder).rglob(suffix))
)
tests = set(re.findall(r"\b(?:fn|def|function) (\w+)\(", sources))
named = re.findall(r"`([a-z][a-z0-9]*(?:_[a-z0-9]+){2,})`", pathlib.Path("docs/conformance.md").read_text())
missing = sorted(set(named) - tests)
print(f"{len(set(named))} tests named, {len(missing)} of them missing", *missing, sep="\n")
sys.exit(bool(missing))
