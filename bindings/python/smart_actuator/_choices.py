"""Arguments that are one of a few names, for type checkers; ``tests/test_types.py`` compares them."""

from typing import Literal

ModelName = Literal["board", "grey-box", "black-box-1", "black-box-2"]
FittedModelName = Literal[
    "black-box-1",
    "black-box-2",
    "black-box-2-oscillator",
    "grey-box",
    "motor-m1",
    "motor-m2",
    "motor-m3",
    "motor-m4",
    "motor-m5",
    "motor-m6",
    "servo-m1",
    "servo-m2",
    "servo-m3",
    "servo-m4",
    "servo-m5",
    "servo-m6",
]
PlantName = Literal["first-order", "bench"]
PresetName = Literal[
    "paper",
    "consistent",
    "asymmetric",
    "as-measured",
    "as-measured-retuned",
    "as-printed",
    "as-printed-strict",
]
InputName = Literal[
    "pulse",
    "variable-step",
    "ramp",
    "chirp",
    "log-chirp",
    "sine",
    "3-2-1-1",
    "doublet",
    "prbs",
    "multisine",
]
PwmName = Literal["average", "switched"]
CommandName = Literal["position", "rate", "duty", "voltage"]
LoopName = Literal["closed", "open", "rate", "motor"]
LossName = Literal["auto", "squares", "robust"]
HoldName = Literal["zero", "smooth"]
DelimiterName = Literal["comma", "semicolon", "tab", "blanks"]
TargetName = Literal[
    "mujoco-position",
    "mujoco-dcmotor",
    "jsbsim",
    "bam",
    "matlab",
    "python-control",
    "gazebo",
    "isaaclab",
    "newton",
    "ardupilot-sitl",
]
