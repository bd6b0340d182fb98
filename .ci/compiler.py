#!/usr/bin/env python3
"""Fails if a default member depends on a crate that declares a newer compiler than the pinned one."""
import json
import re
import subprocess
import sys


def version(text):
    """The first two numbers of a version."""
    return tuple(int(number) for number in text.split(".")[:2])


def main():
    with open("rust-toolchain.toml", encoding="utf-8") as file:
        pinned = re.search(r'channel = "([0-9.]+)"', file.read())[1]
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", "x86_64-unknown-linux-gnu"]
    metadata = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    dependencies = {node["id"]: node["dependencies"] for node in metadata["resolve"]["nodes"]}
    reached, todo = set(), list(metadata["workspace_default_members"])
    while todo:
        package = todo.pop()
        if package not in reached:
            reached.add(package)
            todo += dependencies[package]
    newer = [
        f"{p['name']} {p['version']} needs Rust {p['rust_version']}"
        for p in metadata["packages"]
        if p["id"] in reached and p["rust_version"] and version(p["rust_version"]) > version(pinned)
    ]
    print(f"{len(reached)} packages, {len(newer)} need more than Rust {pinned}")
    print("\n".join(newer))
    return 1 if newer else 0


if __name__ == "__main__":
    sys.exit(main())
