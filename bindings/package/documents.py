"""Runs every block of the documents of Python, MuJoCo and FMI, and the notebook, as a reader without
Rust does: from a package alone, in a new environment of Python.

    python3 documents.py PACKAGE ACTUATOR FOLDER

PACKAGE is the folder that `cargo run --release --bin package` makes, or one with the wheel; ACTUATOR
is the program. The environment is `clean` in FOLDER.
"""

import os
import re
import shutil
import subprocess
import sys
import time
import venv
from pathlib import Path

BINDINGS = Path(__file__).resolve().parent.parent
DOCUMENTS = ["python/README.md", "mujoco/README.md", "fmu/README.md"]
NOTEBOOK = BINDINGS / "python/examples/from_paper_to_simulator.ipynb"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
RUN_NOTEBOOK = """
import nbclient, nbformat, sys
book = nbformat.read(sys.argv[1], as_version=4)
nbclient.NotebookClient(book, timeout=300).execute()
"""


def environment(folder, actuator):
    """The variables of a reader who has the program and the new environment of Python."""
    programs = folder / "programs"
    programs.mkdir()
    (programs / "actuator").symlink_to(actuator)
    venv.create(folder / "clean", clear=True, with_pip=True)
    path = f"{folder}/clean/bin:{programs}:/usr/bin:/bin"
    for tool in ["cargo", "rustc"]:
        if place := shutil.which(tool, path=path):
            sys.exit(f"{place}: the documents are for readers without it")
    return {
        "HOME": os.environ["HOME"],
        "PATH": path,
        "MPLBACKEND": "Agg",
        "PIP_QUIET": "1",
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
    }


def main():
    package, actuator, folder = (Path(argument).resolve() for argument in sys.argv[1:])
    work = folder / "documents"
    shutil.rmtree(work, ignore_errors=True)
    shutil.rmtree(folder / "programs", ignore_errors=True)
    work.mkdir(parents=True)
    variables = environment(folder, actuator)
    (work / "dist").symlink_to(package)

    def run(what, *command):
        begin = time.monotonic()
        subprocess.run(command, cwd=work, env=variables, check=True)
        print(f"{what}: {time.monotonic() - begin:.0f} s", flush=True)

    programs = {"sh": ["bash", "-euc"], "python": ["python", "-c"]}
    for document in DOCUMENTS:
        text = (BINDINGS / document).read_text()
        assert "\n    " not in BLOCK.sub("", text), f"{document}: a block without a language"
        for language, block in BLOCK.findall(text):
            run(f"{document}: {block.splitlines()[0]}", *programs[language], block)
    run("packages of the notebook", "pip", "install", "matplotlib", "control", "nbclient", "ipykernel")
    run(NOTEBOOK.name, "python", "-c", RUN_NOTEBOOK, str(NOTEBOOK))


if __name__ == "__main__":
    main()
