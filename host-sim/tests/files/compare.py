"""Compares trace files with the CSV of the same run, bit for bit."""
import sys

import numpy as np
import pyarrow.parquet
import scipy.io


def same_bits(name, one, other):
    one, other = (np.ascontiguousarray(x, np.float64).view(np.uint64) for x in (one, other))
    assert np.array_equal(one, other), f"{name} differs"


def parameters(meta):
    numbers = meta["parameters"][0, 0]
    return {name: numbers[name][0, 0].item() for name in numbers.dtype.names}


def main(csv_path, mat_path, parquet_path=None):
    csv = np.genfromtxt(csv_path, delimiter=",", names=True, ndmin=1)
    names = list(csv.dtype.names)

    trace = scipy.io.loadmat(mat_path)["trace"]
    assert trace.shape == (1, 1) and list(trace.dtype.names) == names + ["units", "meta"]
    for name in names:
        column = trace[name][0, 0]
        assert column.shape == (len(csv), 1) and column.dtype == np.float64
        same_bits(f"{mat_path}: {name}", column[:, 0], csv[name])
    units, meta = (trace[name][0, 0] for name in ("units", "meta"))
    assert list(units.dtype.names) == names and units["rate_deg_s"][0, 0].item() == "deg/s"
    assert meta["model"][0, 0].item() == "board" and meta["preset"][0, 0].item() == "consistent"
    print(f"{len(csv)} rows of {len(names)} columns: scipy reads what the CSV says")
    if parquet_path:
        compare_parquet(parquet_path, csv, names, parameters(meta))


def compare_parquet(parquet_path, csv, names, expected):
    table = pyarrow.parquet.read_table(parquet_path)
    assert table.column_names == names
    for name in names:
        assert table[name].null_count == 0
        same_bits(f"{parquet_path}: {name}", table[name].to_numpy(), csv[name])
    pairs = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    assert pairs["model"] == "board" and pairs["units.rate_deg_s"] == "deg/s"
    for name, value in expected.items():
        assert float(pairs[f"parameters.{name}"]) == value, name
    print("pyarrow as well")


main(*sys.argv[1:])
