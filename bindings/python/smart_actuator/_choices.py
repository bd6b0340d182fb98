"""Arguments that are one of a few names, for type checkers; ``tests/test_types.py`` compares them."""

from typing import Literal

ModelName = Literal["board", "grey-box", "black-box-1", "black-box-2"]
PlantName = Literal["first-order", "bench"]
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
