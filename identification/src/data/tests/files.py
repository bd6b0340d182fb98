"""Writes the files beside it, by other libraries: numpy 2.4, scipy 1.17, pandas 3, h5py 3, pyarrow,
mcap-ros2-support 0.6."""

import h5py
import mcap_ros2.writer
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

# Bags of ROS 2: the joints of an arm, and the commands to its controller.
STAMP = """
================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
JOINTS = "uint8 UNKNOWN=0  # unused\nstd_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[<=8] velocity" + STAMP
COMMANDS = "bool is_absolute\nint16[3] reserved\nstring<=9 note\nfloat32[] data\n"
with open("bag.mcap", "wb") as file:
    writer = mcap_ros2.writer.Writer(file)
    joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
    commands = writer.register_msgdef("x_msgs/msg/Commands", COMMANDS)
    for index in range(4):
        stamp = {"sec": 1_700_000_000, "nanosec": index * 10_000_000}
        time_ns = 1_700_000_000_000_000_000 + index * 10_000_000
        if index % 2 == 0:
            message = {"is_absolute": True, "reserved": [1, 2, 3], "note": "arm", "data": [index, 0.5]}
            writer.write_message("/arm/commands", commands, message, time_ns, time_ns)
        message = {
            "header": {"stamp": stamp, "frame_id": "base"},
            "name": ["elbow", "wrist"],
            "position": [index / 8, 7.0],
            "velocity": [],
        }
        # The log is late by a varying time; the stamp is not.
        writer.write_message("/joint_states", joints, message, time_ns + 500_000 * (3 - index), time_ns)
    writer.finish()
