"""Every table and file format with every function that takes one, in both directions."""

import os
import subprocess

import numpy as np
import pandas
import polars
import pyarrow
import pyarrow.parquet
import pytest
import scipy.io

import smart_actuator as sa

PROGRAM = os.environ.get("ACTUATOR", "actuator")

#: Ways of a trace through another library and back into a file or table.
WRITERS = {
    "trace": lambda trace, path: trace,
    "dictionary": lambda trace, path: dict(trace),
    "structured array": lambda trace, path: trace.to_pandas().to_records(index=False),
    "pandas": lambda trace, path: trace.to_pandas(),
    "polars": lambda trace, path: polars.DataFrame(trace),
    "pyarrow": lambda trace, path: pyarrow.table(trace),
    "pandas parquet": lambda trace, path: _by_file(
        trace.to_pandas().to_parquet, pandas.read_parquet, path / "run.parquet"
    ),
    "polars parquet": lambda trace, path: _by_file(
        polars.DataFrame(trace).write_parquet, polars.read_parquet, path / "run.parquet"
    ),
    "pandas csv": lambda trace, path: _file(
        lambda p: trace.to_pandas().to_csv(p, index=False), path / "run.csv"
    ),
    "polars csv": lambda trace, path: _file(polars.DataFrame(trace).write_csv, path / "run.csv"),
    "numpy csv": lambda trace, path: _file(
        lambda p: np.savetxt(p, trace.to_numpy(), "%.17g", ",", header=",".join(trace), comments=""),
        path / "run.csv",
    ),
    "scipy mat": lambda trace, path: _file(lambda p: scipy.io.savemat(p, trace), path / "run.mat"),
    "scipy mat struct": lambda trace, path: _file(
        lambda p: scipy.io.savemat(p, {"run": dict(trace)}, do_compression=True), path / "run.mat"
    ),
}


def _file(write, path):
    write(path)
    return path


def _by_file(write, read, path):
    return read(_file(write, path))


def program(*arguments):
    command = [PROGRAM, *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def trace():
    return sa.simulate("board", input="3-2-1-1", every=80)


@pytest.fixture(scope="module")
def fitted(trace):
    return parameters(sa.identify(trace, models="black-box-1", starts=1))


def parameters(found):
    return [p["estimate"] for p in found["models"][0]["parameters"]]


@pytest.mark.parametrize("writer", WRITERS)
def test_every_reader_takes_every_table(writer, trace, fitted, tmp_path):
    table = WRITERS[writer](trace, tmp_path)
    assert parameters(sa.identify(table, models="black-box-1", starts=1)) == fitted
    if isinstance(table, os.PathLike):
        # The program reads the same files.
        run = program("simulate", "board", "--input-file", table, "--every", 80, "--csv", "-")
        again = np.genfromtxt(run.splitlines(), delimiter=",", names=True)
        assert np.array_equal(again["command_deg"], trace.command_deg)
        assert "pole_rad_s" in program("identify", table, "--model", "black-box-1", "--starts", 1)
    else:
        again = sa.simulate(command=table, every=80)
        assert np.array_equal(again.command_deg, trace.command_deg)


def test_what_the_program_writes_is_read_by_others(trace, tmp_path):
    paths = [tmp_path / "run.csv", tmp_path / "run.mat"]
    options = ["--csv", paths[0], "--out", paths[1]]
    program("simulate", "board", "--input", "3-2-1-1", "--every", 80, *options)
    mat = scipy.io.loadmat(paths[1])["trace"]
    for table in (
        pandas.read_csv(paths[0]),
        polars.read_csv(paths[0], infer_schema_length=None),
        np.genfromtxt(paths[0], delimiter=",", names=True),
        {name: mat[name][0, 0].ravel() for name in trace},
    ):
        for name, column in trace.items():
            assert np.array_equal(np.asarray(table[name], float), column), (type(table), name)
