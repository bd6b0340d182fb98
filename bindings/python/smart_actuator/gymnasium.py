"""Environments of Gymnasium: an actuator follows a target that jumps.

Optional: ``pip install smart-actuator[gymnasium]``. Importing this module registers
``smart_actuator/Follow-v0``, which ``gymnasium.make`` and ``gymnasium.make_vec`` make.

- action: the command, -1 to 1 of ``amplitude_deg``
- observation: target, measured angle (of ``amplitude_deg``) and measured rate (of 1000 deg/s), as the
  board measures them; and the last action
- reward: minus the distance from target to true angle and a tenth of the change of the action, both
  of ``amplitude_deg``
- an episode is truncated after ``steps`` steps of ``step_s``; it does not terminate
"""

from __future__ import annotations

from typing import Any, Callable, Dict, Mapping, Optional, Sequence, Tuple

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import _arguments
from ._batch import ActuatorBatch
from ._tables import parameters as parameter_table

Array = NDArray[np.float64]
#: Draws the parameters of a number of actuators.
Sampler = Callable[[np.random.Generator, int], Mapping[str, Array]]

_RATE_DEG_S = 1000.0


def posterior(
    fitted: Mapping[str, Any], *, widen: float = 1.0, only: Optional[Sequence[str]] = None
) -> Sampler:
    """Draws parameters from the posterior of an identified model, ``identify(...)["models"][0]``.

    It is the normal distribution of the estimates with their covariance for coloured residuals,
    limited to the ranges of the simulator; parameters that the recording does not identify, and those
    that the simulator does not have, keep their estimates or defaults.

    :param widen: factor of all standard deviations.
    :param only: the parameters that are drawn; by default all that were identified.
    """
    fitted_model = isinstance(fitted, Mapping) and {"model", "parameters", "correlation"} <= set(fitted)
    if not fitted_model:
        raise TypeError('fitted is no fitted model, expected identify(...)["models"][0]')
    widen = _arguments.within("widen", widen, 0.0, 1e6)
    chosen = None if only is None else _arguments.names("only", only)
    kind: Any = fitted["model"] if fitted["model"] != "black-box-2-oscillator" else "black-box-2"
    ranges = {row["name"]: (row["min"], row["max"]) for row in parameter_table(kind)}
    order = fitted["correlation"]["parameters"]
    estimates = {p["name"]: p for p in fitted["parameters"] if p["experiment"] is None}
    covariance = np.array(fitted["covariance_coloured"], dtype=float)
    known = [
        i
        for i, name in enumerate(order)
        if name in ranges
        and name in estimates
        and estimates[name]["identifiable"]
        and (chosen is None or name in chosen)
        and np.isfinite(covariance[i, i])
    ]
    found = [order[i] for i in known]
    missing = sorted(set(chosen or ()).difference(found))
    if missing or not known:
        which = missing[0] if missing else "any parameter"
        raise ValueError(f"only: the fit has not identified {which}, or the simulator lacks it")
    names = [order[i] for i in known]
    # The others keep their estimates, those at infinity their defaults.
    kept = {
        name: min(max(one["estimate"], ranges[name][0]), ranges[name][1])
        for name, one in estimates.items()
        if name in ranges and name not in names and one["estimate"] is not None
    }
    mean = np.array([estimates[name]["estimate"] for name in names])
    spread = widen**2 * covariance[np.ix_(known, known)]
    low, high = np.array([ranges[name] for name in names]).T

    def sample(rng: np.random.Generator, count: int) -> Mapping[str, Array]:
        drawn = np.clip(rng.multivariate_normal(mean, spread, count, method="eigh"), low, high)
        same = {name: np.full(count, value) for name, value in kept.items()}
        return {**same, **dict(zip(names, drawn.T))}

    return sample


def _nominal(rng: np.random.Generator, count: int) -> Mapping[str, Array]:
    return {}


class _Task:
    """Targets, rewards and observations of some actuators."""

    def __init__(self, count: int, amplitude_deg: float, jump: float) -> None:
        self.amplitude_deg, self.jump = amplitude_deg, jump
        self.target, self.action = np.zeros(count), np.zeros(count)

    def begin(self, rngs: Sequence[np.random.Generator], which: NDArray[np.intp]) -> None:
        for i in which:
            self.target[i], self.action[i] = rngs[i].uniform(-1, 1), 0.0

    def judge(self, action: Array, states: Array) -> Array:
        change = np.abs(action - self.action)
        self.action = action.copy()
        return -np.abs(self.target - states[:, 0] / self.amplitude_deg) - 0.1 * change

    def move(self, rngs: Sequence[np.random.Generator]) -> None:
        for i, rng in enumerate(rngs):
            if rng.random() < self.jump:
                self.target[i] = rng.uniform(-1, 1)

    def observe(self, states: Array) -> NDArray[np.float32]:
        columns = (
            self.target,
            states[:, 2] / self.amplitude_deg,
            states[:, 3] / _RATE_DEG_S,
            self.action,
        )
        return np.clip(np.stack(columns, axis=1), -10, 10).astype(np.float32)


class ActuatorVectorEnv(gymnasium.vector.VectorEnv):
    """Many actuators with targets of their own, stepped on all cores.

    :param num_envs: how many.
    :param randomise: draws the parameters of the actuators at each reset, such as
        :func:`posterior`; by default all are equal.
    :param amplitude_deg: of targets and commands, deg.
    :param steps: of an episode.
    :param step_s: time of a step, s.
    :param jump: probability of a jump of the target in a step.
    :param threads: number of threads; by default one per core.
    :param actuator: the model and its fixed parameters, as for :class:`ActuatorBatch`.
    """

    metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(
        self,
        num_envs: int = 1,
        *,
        randomise: Optional[Sampler] = None,
        amplitude_deg: float = 60.0,
        steps: int = 200,
        step_s: float = 0.02,
        jump: float = 0.02,
        threads: Optional[int] = None,
        **actuator: Any,
    ) -> None:
        self.num_envs = _arguments.whole("num_envs", num_envs, 1, 2**20)
        if randomise is not None and not callable(randomise):
            shown = _arguments.shown(randomise)
            raise TypeError(f"randomise is {shown}, expected a function such as posterior(...)")
        steps = _arguments.whole("steps", steps, 1)
        jump = _arguments.within("jump", jump, 0.0, 1.0)
        amplitude_deg = _arguments.within("amplitude_deg", amplitude_deg, 1e-3, 3.6e4, "deg")
        self.single_action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.single_observation_space = spaces.Box(-10.0, 10.0, (4,), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.render_mode = None
        self._randomise, self._steps = _nominal if randomise is None else randomise, steps
        self._make = {"step_s": step_s, "threads": threads, "count": num_envs, **actuator}
        self._task = _Task(num_envs, amplitude_deg, jump)
        self._age = np.zeros(num_envs, dtype=np.int64)
        self._over = np.zeros(num_envs, dtype=bool)
        self._rngs: list[np.random.Generator] = []
        self._batch: Optional[ActuatorBatch] = None
        self._rng = np.random.default_rng()

    def reset(
        self,
        *,
        seed: Any = None,
        options: Optional[Dict[str, Any]] = None,
    ) -> Tuple[NDArray[np.float32], Dict[str, Any]]:
        """Starts all episodes; actuator ``i`` has the seed ``seed + i``, or ``seed[i]``."""
        if seed is not None or not self._rngs:
            seeds: Any = [None] * self.num_envs
            if isinstance(seed, (list, tuple)):
                seeds = list(seed)
                if len(seeds) != self.num_envs:
                    raise ValueError(f"seed has {len(seeds)} elements, expected {self.num_envs}")
            elif seed is not None:
                seeds = [_arguments.whole("seed", seed) + i for i in range(self.num_envs)]
            self._rngs = [np.random.default_rng(one) for one in seeds]
            self._rng = np.random.default_rng(None if seed is None else seeds)
        drawn = self._randomise(self._rng, self.num_envs)
        noise = int(self._rng.integers(2**31))
        self._batch = ActuatorBatch(drawn, seed=noise, **self._make)
        self._begin(np.arange(self.num_envs))
        return self._task.observe(self._batch.states), {}

    def step(
        self, actions: Any
    ) -> Tuple[NDArray[np.float32], Array, NDArray[np.bool_], NDArray[np.bool_], Dict[str, Any]]:
        """One step of all; an episode that was truncated in the last one begins instead."""
        if self._batch is None:
            raise gymnasium.error.ResetNeeded("call reset before step")
        given = _arguments.array("actions", actions)
        if given.size != self.num_envs:
            raise ValueError(f"actions of shape {given.shape}, expected ({self.num_envs}, 1)")
        if not np.isfinite(given).all():
            raise ValueError("actions are not all finite, expected numbers from -1 to 1")
        action = np.clip(given.reshape(self.num_envs), -1, 1)
        began = np.flatnonzero(self._over)
        states = self._batch.step(self._task.amplitude_deg * action)
        reward = self._task.judge(action, states)
        self._age += 1
        self._task.move(self._rngs)
        if began.size:
            drawn = self._randomise(self._rng, began.size)
            self._batch.replace(began.tolist(), drawn, seed=int(self._rng.integers(2**31)))
            self._begin(began)
            reward[began] = 0.0
        self._over = self._age >= self._steps
        observation = self._task.observe(states)
        return observation, reward, np.zeros(self.num_envs, dtype=bool), self._over.copy(), {}

    def _begin(self, which: NDArray[np.intp]) -> None:
        self._task.begin(self._rngs, which)
        self._age[which] = 0
        self._over[which] = False


class ActuatorEnv(gymnasium.Env):
    """One actuator; the arguments are those of :class:`ActuatorVectorEnv`."""

    metadata = {"render_modes": []}

    def __init__(self, render_mode: Optional[str] = None, **arguments: Any) -> None:
        self._vector = ActuatorVectorEnv(1, **{"threads": 1, **arguments})
        self.render_mode = render_mode
        self.action_space = self._vector.single_action_space
        self.observation_space = self._vector.single_observation_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None
    ) -> Tuple[NDArray[np.float32], Dict[str, Any]]:
        super().reset(seed=seed)
        observation, info = self._vector.reset(seed=seed, options=options)
        return observation[0], info

    def step(self, action: Any) -> Tuple[NDArray[np.float32], float, bool, bool, Dict[str, Any]]:
        if self._vector._over[0]:
            raise gymnasium.error.ResetNeeded("the episode is over, call reset")
        observation, reward, terminated, truncated, info = self._vector.step(action)
        return observation[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]), info


gymnasium.register(
    "smart_actuator/Follow-v0",
    entry_point="smart_actuator.gymnasium:ActuatorEnv",
    vector_entry_point="smart_actuator.gymnasium:ActuatorVectorEnv",
)
