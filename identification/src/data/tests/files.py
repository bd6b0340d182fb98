"""Writes the files beside it, by other libraries: numpy 2.4, scipy 1.17, pandas 3, h5py 3, pyarrow."""

import h5py
import numpy
import pandas
import pyarrow
import pyarrow.parquet
import scipy.io

TABLE = pandas.DataFrame({"time_s": [0.0, 0.1], "command_deg": [1.0, 3.0], "angle_deg": [2.0, 4.0]})
TABLE.to_excel("table.xlsx", index=False)
TABLE.to_parquet("table.parquet", index=False)
# As MATLAB writes a struct of columns in version 7.3.
with h5py.File("table.h5", "w") as file:
    group = file.create_group("run")
    for name in TABLE:
        group.create_dataset(name, data=TABLE[name].to_numpy()[None, :], compression="gzip")

MATRIX = numpy.array([[0, 1, 2], [0.1, 3, 4], [0.2, 5, 6], [0.3, 7, 8]])
scipy.io.savemat("matrix.mat", {"data": MATRIX})

# The table of a LeRobot data set: two episodes of two joints.
vector = pyarrow.list_(pyarrow.float32())
columns = {
    "action": pyarrow.array([[1, 5], [3, 6], [1, 5], [3, 6]], vector),
    "observation.state": pyarrow.array([[2, 7], [4, 8], [20, 7], [40, 8]], vector),
    "timestamp": pyarrow.array([0, 0.1, 0, 0.1], pyarrow.float32()),
    "episode_index": [0, 0, 1, 1],
}
pyarrow.parquet.write_table(pyarrow.table(columns), "episodes.parquet")
