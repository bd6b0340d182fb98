"""An actuator that is stepped by another simulation."""

from __future__ import annotations

import zlib
from types import MappingProxyType
from typing import TYPE_CHECKING, Mapping, NamedTuple, Optional, overload

from . import _arguments, _native
from ._choices import CommandName, ModelName, PlantName, PresetName, PwmName

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._parameters import ModelParameters

_TICKS_PER_SECOND = 20_000
#: Four months, the longest run, s.
_LONGEST_S = 1e7


class Reading(NamedTuple):
    """The outputs of an actuator.

    A quantity that the model does not have is zero; one that it does not measure is the true value.
    """

    time_s: float
    """Time, s."""
    command_delayed_deg: float
    """The command behind the transport delay, deg."""
    angle_deg: float
    """Angle of the output shaft, deg."""
    rate_deg_s: float
    """Rate of the output shaft, deg/s."""
    duty_pct: float
    """Duty of the bridge, %."""
    angle_meas_deg: float
    """Measured angle, deg."""
    rate_meas_deg_s: float
    """Measured rate, deg/s."""
    current_a: float
    """Motor current, A; of the bench only."""
    back_emf_v: float
    """Back-EMF, V; of the bench only."""


def _checked(snapshot: bytes) -> bytes:
    """The content of a snapshot, behind its CRC-32."""
    if not isinstance(snapshot, bytes):
        raise TypeError(f"snapshot is of {type(snapshot).__name__}, expected bytes")
    kept = snapshot[4:]
    if zlib.crc32(kept).to_bytes(4, "big") != snapshot[:4]:
        raise ValueError("not a snapshot of an actuator: its checksum is wrong")
    return kept


class Actuator:
    """An actuator that is stepped by its caller. It starts at rest at 0 deg.

    The board's control runs every 4 ms of simulated time, and the state at an instant does not
    depend on the step sizes before it. An actuator can be copied and pickled. Threads that share
    one are serialised by a lock.

    :param model: as for :func:`simulate`, as are ``plant``, ``preset``, ``seed``, ``pwm`` and
        ``parameters``.
    """

    __slots__ = ("_native",)
    _native: _native.Actuator

    def __init__(
        self,
        model: ModelName = "board",
        *,
        plant: Optional[PlantName] = None,
        preset: Optional[PresetName] = None,
        seed: int = 0,
        pwm: PwmName = "average",
        **parameters: Unpack[ModelParameters],
    ) -> None:
        _arguments.warn(preset)
        self._native = _native.Actuator(
            _arguments.text("model", model),
            _arguments.optional_text("plant", plant),
            _arguments.optional_text("preset", preset),
            _arguments.whole("seed", seed),
            _arguments.text("pwm", pwm),
            _arguments.pairs("parameters", parameters),
        )

    @overload
    def advance(
        self, command_deg: float, *, ticks: int, seconds: None = None, input: CommandName = "position"
    ) -> Reading: ...
    @overload
    def advance(
        self, command_deg: float, *, ticks: None = None, seconds: float, input: CommandName = "position"
    ) -> Reading: ...
    def advance(
        self,
        command_deg: float,
        *,
        ticks: Optional[int] = None,
        seconds: Optional[float] = None,
        input: CommandName = "position",
    ) -> Reading:
        """Advances the simulation with a constant command, and returns the outputs.

        The simulation advances by whole ticks of 50 us. A step of any other length ends at the tick
        that is nearest to the sum of all steps: there is no drift.

        :param command_deg: the command, deg. The first one is also the past of the delay line.
        :param ticks: step size, ticks of 50 us; or
        :param seconds: step size, s, up to 1e7.
        :param input: what the command is: ``position`` (deg), ``rate`` (deg/s, without the position
            loop), ``duty`` (%, without any loop) or, of the bench, ``voltage`` at the motor (V).
        """
        _arguments.text("input", input)
        if (ticks is None) == (seconds is None):
            raise TypeError("expected either ticks or seconds")
        command_deg = _arguments.number("command_deg", command_deg)
        if seconds is None:
            count = _arguments.whole("ticks", ticks)
            return Reading(*self._native.advance(input, command_deg, count))
        step = _time("seconds", seconds)
        return Reading(*self._native.advance_seconds(input, command_deg, step))

    def advance_to(
        self, command_deg: float, time_s: float, *, input: CommandName = "position"
    ) -> Reading:
        """Advances to the tick nearest to a time since the start, and returns the outputs.

        :param command_deg: the command, deg.
        :param time_s: time, s, up to 1e7; not before that of the actuator.
        :param input: as for :meth:`advance`.
        """
        _arguments.text("input", input)
        command_deg = _arguments.number("command_deg", command_deg)
        return Reading(*self._native.advance_to(input, command_deg, _time("time_s", time_s)))

    def reading(self) -> Reading:
        """The outputs now, before the updates of the next step at this instant."""
        return Reading(*self._native.reading())

    def set_load_torque(self, torque_nm: float) -> None:
        """Applies a torque to the load of the bench, Nm, from the next tick (50 us) on, in
        addition to the one of its parameters."""
        self._native.set_load_torque(_arguments.number("torque_nm", torque_nm))

    def set_load_inertia(self, inertia_kg_m2: float) -> None:
        """Adds an inertia to the load of the bench, kg m^2, from the next tick on, in addition to the
        one of its parameters. A greater one than 1000 counts as 1000."""
        self._native.set_load_inertia(_arguments.number("inertia_kg_m2", inertia_kg_m2))

    def place(self, angle_deg: float) -> None:
        """Places the shaft at an angle, deg, before the first step. The board then measures it
        within half a turn."""
        self._native.place(_arguments.number("angle_deg", angle_deg))

    def snapshot(self) -> bytes:
        """The whole state, for :meth:`restore` of the same version of the package."""
        kept = self._native.snapshot()
        return zlib.crc32(kept).to_bytes(4, "big") + kept

    def restore(self, snapshot: bytes) -> None:
        """Goes back to a snapshot of an actuator of the same model, seed and parameters.

        :raises ValueError: a snapshot of another actuator or version, or a damaged one.
        """
        self._native.restore(_checked(snapshot))

    @property
    def time(self) -> float:
        """The simulated time, s."""
        return self.tick / _TICKS_PER_SECOND

    @property
    def tick(self) -> int:
        """The simulated time, ticks of 50 us."""
        return self._native.tick

    @property
    def model(self) -> str:
        """The model."""
        return self._native.settings["model"]

    @property
    def plant(self) -> Optional[str]:
        """The plant behind the board; None for the other models."""
        return self._native.settings["plant"]

    @property
    def seed(self) -> int:
        """The seed of the random numbers."""
        return self._native.settings["seed"]

    @property
    def pwm(self) -> str:
        """How the bridge is switched."""
        return self._native.settings["pwm"]

    @property
    def parameters(self) -> Mapping[str, float]:
        """Every parameter by name, read only: parameters are given when an actuator is made.
        :func:`smart_actuator.parameters` lists the units."""
        return MappingProxyType(self._native.settings["parameters"])

    def __copy__(self) -> Actuator:
        copy = object.__new__(type(self))
        copy._native = self._native.copy()
        return copy

    def __deepcopy__(self, memo: object) -> Actuator:
        return self.__copy__()

    def __reduce__(self) -> tuple[object, ...]:
        return _kept, (type(self), self.snapshot())

    def __repr__(self) -> str:
        plant = f" on {self.plant}" if self.plant else ""
        now = self.reading()
        return f"<Actuator {self.model}{plant} at {now.time_s} s: {now.angle_deg:.3f} deg>"


def _kept(kind: type[Actuator], snapshot: bytes) -> Actuator:
    actuator = object.__new__(kind)
    actuator._native = _native.Actuator.kept(_checked(snapshot))
    return actuator


def _time(name: str, value: object) -> float:
    seconds = _arguments.number(name, value)
    # Written so that NaN fails.
    if not 0.0 <= seconds <= _LONGEST_S:
        raise ValueError(f"{name} is {seconds}, expected a time from 0 to 1e7 s")
    return seconds
