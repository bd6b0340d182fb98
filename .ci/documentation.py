#!/usr/bin/env python3
"""Documents all packages, or those of the workspace of another manifest; fails on a warning, and on
more than 38,000 words in docs/*.md.

With the features of clippy, and with the examples: only with them does cargo give the dependencies
the features of the tests, with which clippy has checked them already. A program that is named as
the library of its package has no documentation beside that of the library, as in a plain
`cargo doc`.
"""
import json
import os
import pathlib
import subprocess
import sys

MANIFEST = [f"--manifest-path={path}" for path in sys.argv[1:]]
MOST_WORDS = 38_000
LIBRARIES = {"lib", "rlib", "cdylib", "staticlib"}


def crate(target):
    return target["name"].replace("-", "_")


def programs(package):
    targets = package["targets"]
    libraries = {crate(t) for t in targets if LIBRARIES & set(t["kind"])}
    return [t["name"] for t in targets if t["kind"] == ["bin"] and t["doc"] and crate(t) not in libraries]


def words():
    pages = pathlib.Path(__file__).parent.parent.joinpath("docs").glob("*.md")
    # The bars and rules of tables are no words.
    texts = (page.read_text(encoding="utf-8").split() for page in pages)
    return sum(any(map(str.isalnum, word)) for text in texts for word in text)


def main():
    if words() > MOST_WORDS:
        return f"docs/*.md have {words()} words, expected at most {MOST_WORDS}"
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--no-deps"] + MANIFEST
    packages = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["packages"]
    command = ["cargo", "doc", "--workspace", "--no-deps", "--ignore-rust-version", "--locked", "--lib", "--examples"] + MANIFEST
    if not MANIFEST:
        command.append("--features=actuator/board,actuator/formats")
    command += [f"--bin={name}" for package in packages for name in programs(package)]
    return subprocess.run(command, env={**os.environ, "RUSTDOCFLAGS": "-D warnings"}).returncode


if __name__ == "__main__":
    sys.exit(main())
