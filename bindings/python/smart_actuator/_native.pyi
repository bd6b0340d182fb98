from typing import Any, Optional, TypedDict, final

import numpy as np
from numpy.typing import NDArray

from ._export import Export
from ._progress import Report
from ._tables import Input, Parameter, Preset

__all__ = [
    "__version__",
    "Actuator",
    "ActuatorBatch",
    "command_sensitivity",
    "sensitivity",
    "simulate",
    "monte_carlo",
    "export",
    "identify",
    "presets",
    "parameters",
    "inputs",
]
__version__: str

class _Settings(TypedDict):
    model: str
    plant: Optional[str]
    pwm: str
    seed: int
    parameters: dict[str, float]

#: A file or its columns, the window, s, and the known constants.
_Run = tuple[Any, Optional[tuple[float, float]], list[tuple[str, float]]]
_Reading = tuple[float, float, float, float, float, float, float, float, float]

@final
class Actuator:
    def __new__(
        cls,
        model: str,
        plant: Optional[str],
        preset: Optional[str],
        seed: int,
        pwm: str,
        parameters: list[tuple[str, float]],
    ) -> Actuator: ...
    def advance(self, input: str, value: float, ticks: int) -> _Reading: ...
    def advance_seconds(self, input: str, value: float, seconds: float) -> _Reading: ...
    def advance_to(self, input: str, value: float, time_s: float) -> _Reading: ...
    def place(self, angle_deg: float) -> None: ...
    def set_load_inertia(self, inertia_kg_m2: float) -> None: ...
    def reading(self) -> _Reading: ...
    def set_load_torque(self, torque_nm: float) -> None: ...
    @property
    def tick(self) -> int: ...
    @property
    def settings(self) -> _Settings: ...
    def snapshot(self) -> bytes: ...
    def restore(self, bytes: bytes) -> None: ...
    @staticmethod
    def kept(bytes: bytes) -> Actuator: ...
    def copy(self) -> Actuator: ...

@final
class ActuatorBatch:
    def __new__(
        cls,
        model: str,
        plant: Optional[str],
        preset: Optional[str],
        seed: int,
        parameters: list[tuple[str, float]],
        names: list[str],
        values: NDArray[np.float64],
        ticks: int,
        threads: int,
    ) -> ActuatorBatch: ...
    def step(self, commands: NDArray[np.float64], out: NDArray[np.float64]) -> None: ...
    def replace(self, indices: list[int], values: NDArray[np.float64], seed: int) -> None: ...

def sensitivity(
    model: str,
    time_s: NDArray[np.float64],
    command_deg: NDArray[np.float64],
    duty_pct: Optional[NDArray[np.float64]],
    values: tuple[list[tuple[str, float]], bool],
    by: list[str],
) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]: ...
def command_sensitivity(
    model: str,
    time_s: NDArray[np.float64],
    command_deg: NDArray[np.float64],
    starts: list[int],
    values: tuple[list[tuple[str, float]], bool],
    report: Optional[Report],
) -> NDArray[np.float64]: ...
def simulate(
    request: dict[str, Any], report: Optional[Report]
) -> tuple[str, dict[str, NDArray[np.float64]]]: ...
def monte_carlo(
    request: dict[str, Any],
    names: list[str],
    values: NDArray[np.float64],
    threads: int,
    report: Optional[Report],
) -> NDArray[np.float64]: ...
def identify(
    data: list[_Run],
    validate: list[_Run],
    reading: dict[str, Any],
    search: dict[str, Any],
    report: Optional[Report],
) -> str: ...
def export(to: str, request: dict[str, Any], step_s: Optional[float]) -> Export: ...
def parameters(model: str, plant: Optional[str]) -> list[Parameter]: ...
def presets() -> list[Preset]: ...
def inputs() -> list[Input]: ...
