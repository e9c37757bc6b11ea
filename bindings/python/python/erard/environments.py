"""Gymnasium environments in which an agent plays one key of the grand, or many keys side by side, in a closed loop.

>>> import gymnasium, erard.environments
>>> env = gymnasium.make("erard/Key-v0", control="force")
>>> observation, info = env.reset(seed=1)
>>> observation, reward, terminated, truncated, info = env.step([6.0])

`pip install erard[gymnasium]` installs Gymnasium.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _erard
from ._action import Action
from ._common import floats, number, steps, whole
from ._errors import Extra, InputError
from ._instrument import Instrument, instrument_of, load
from ._many import divided

with Extra("gymnasium"):
    import gymnasium
    from gymnasium.spaces import Box
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._common import Hand

    Floats = NDArray[np.float64]
    #: Of each lane what it earns, from what there is to be read after a period, and the goal, m/s.
    Reward = Callable[[Mapping[str, Floats], Floats], Floats]

#: What is observed, in this order, and how far it may go either way: position of the key's front (m, down), its speed,
#: mean force of the finger on the key over the period (N, pushing), the hammer's rise and speed (m and m/s, up), where
#: the agent's fingertip or hand is (m, down; 0 under a force), the goal (hammer speed at the string, m/s), and the time
#: since the episode began (s).
OBSERVED = {
    "key_m": 0.1,
    "key_m_per_s": 100.0,
    "finger_force_mean_n": 1e4,
    "hammer_rise_m": 1.0,
    "hammer_rise_m_per_s": 100.0,
    "finger_m": 0.1,
    "goal_m_per_s": 10.0,
    "time_s": 1e3,
}
#: What the agent does, least and most: the finger's or the muscle's force, N, or the fingertip's velocity, m/s, down
#: positive.
CONTROLS = {"force": (0.0, 60.0), "motion": (-1.0, 1.0)}
#: Where a fingertip may go, m down from the key's rest.
REACH_M = (-0.02, 0.03)


def speed_reward(now: Mapping[str, Floats], goal_m_per_s: Floats) -> Floats:
    """Returns the default reward: at an impact 1 minus the relative error of the hammer speed, at least -1; otherwise
    0.

    Parameters
    ----------
    now : mapping of str to ndarray of shape (N,)
        Readings of each lane after the period; `hammer_speed_m_per_s` is nan without an impact.
    goal_m_per_s : ndarray of shape (N,)
        Goal of the hammer speed, m/s.

    Returns
    -------
    ndarray of shape (N,)
    """
    error = np.abs(now["hammer_speed_m_per_s"] / goal_m_per_s - 1.0)
    return np.where(np.isnan(error), 0.0, np.maximum(1.0 - error, -1.0))


class _Lanes:
    """Actions side by side, each with its episode: the base of both environments."""

    def __init__(
        self,
        instruments: Sequence[Instrument],
        control: str,
        hand: Hand | None,
        period_s: float,
        duration_s: float,
        goal_m_per_s: tuple[float, float],
        begin: bytes | None,
        reward: Reward | None,
        threads: int | None,
        step: float | None,
    ) -> None:
        if control not in CONTROLS:
            raise InputError(f"control: found {control!r}, expected one of {', '.join(CONTROLS)}", key="control", found=str(control))
        period_s, duration_s = number("period_s", period_s), number("duration_s", duration_s)
        if not 1e-4 <= period_s <= 0.1:
            raise InputError(f"period_s: found {period_s}, expected 0.0001 to 0.1 s", key="period_s", found=str(period_s))
        if not period_s <= duration_s <= OBSERVED["time_s"]:
            expected = f"a period, {period_s}, to {OBSERVED['time_s']:.0f} s"
            raise InputError(f"duration_s: found {duration_s}, expected {expected}", key="duration_s", found=str(duration_s))
        low, high = (float(speed) for speed in floats("goal_m_per_s", goal_m_per_s, 1))
        if not 0.0 < low <= high <= OBSERVED["goal_m_per_s"]:
            found = str((low, high))
            raise InputError(f"goal_m_per_s: found {found}, expected two speeds from 0 to 10 m/s", key="goal_m_per_s", found=found)
        self.has_hand = hand is not None
        self.control, self.goals, self.reward = control, (low, high), reward or speed_reward
        self.period_s, self.periods_max, self.threads = period_s, max(1, round(duration_s / period_s)), threads
        even, self.steps = divided(period_s, steps({"step": step, "hand": hand}), instruments)
        how: dict[str, Any] = {"step": even["step"], "hand": hand}
        self.actions = [Action(instrument, **how) for instrument in instruments]
        self.inner = [action._inner for action in self.actions]
        self.rests = [action.save() if begin is None else begin for action in self.actions]
        count = len(self.actions)
        self.finger_m, self.goal, self.periods = np.zeros(count), np.full(count, low), np.zeros(count, dtype=np.int64)
        self.over = np.zeros(count, dtype=bool)
        for lane in range(count):
            self.reset(lane, low, {})

    def spaces(self) -> tuple[Box, Box]:
        """Returns the spaces of observations and of actions of one lane."""
        most = np.array(list(OBSERVED.values()))
        least, largest = (np.array([end]) for end in CONTROLS[self.control])
        return Box(-most, most, dtype=np.float64), Box(least, largest, dtype=np.float64)

    def reset(self, lane: int, goal: float, options: Mapping[str, Any]) -> None:
        """Begins an episode of a lane, from its rest or from the state in the options."""
        if unknown := set(options) - {"state", "finger_m", "goal_m_per_s", "time_s"}:
            found = ", ".join(sorted(unknown))
            raise InputError(f"options: found {found}; expected state, finger_m, goal_m_per_s, time_s", key="options", found=found)
        goal = number("goal_m_per_s", options.get("goal_m_per_s", goal))
        if not 0.0 < goal <= OBSERVED["goal_m_per_s"]:
            raise InputError(f"goal_m_per_s: found {goal}, expected a speed above 0, to 10 m/s", key="goal_m_per_s", found=str(goal))
        time_s = number("time_s", options.get("time_s", 0.0))
        self.actions[lane].restore(options.get("state", self.rests[lane]))
        at_m = min(max(self.actions[lane].reading.key_m, REACH_M[0]), REACH_M[1])
        self.finger_m[lane] = number("finger_m", options.get("finger_m", at_m)) if self.control == "motion" else 0.0
        self.goal[lane], self.periods[lane], self.over[lane] = goal, round(time_s / self.period_s), False

    def saved(self, lane: int) -> dict[str, Any]:
        """Returns the options with which a reset continues from here, to the bit."""
        return {
            "state": self.actions[lane].save(),
            "finger_m": float(self.finger_m[lane]),
            "goal_m_per_s": float(self.goal[lane]),
            "time_s": float(self.periods[lane] * self.period_s),
        }

    def read(self, lanes: NDArray[np.int64], values: Floats, count: int) -> dict[str, Floats]:
        """Takes steps of some lanes and returns their readings."""
        own = [self.inner[lane] for lane in lanes.tolist()]
        return _erard.advance(own, self.control, np.ascontiguousarray(values), count, self.threads)

    def observed(self, lanes: NDArray[np.int64], now: Mapping[str, Floats]) -> Floats:
        """Returns the observations of some lanes."""
        own = {
            "finger_m": now["hand_m"] if self.control == "force" or self.has_hand else self.finger_m[lanes],
            "goal_m_per_s": self.goal[lanes],
            "time_s": self.periods[lanes] * self.period_s,
        }
        return np.stack([own[name] if name in own else now[name] for name in OBSERVED], axis=1)

    def present(self, lanes: NDArray[np.int64]) -> Floats:
        """Returns the observations of some lanes at the start, before any finger has pushed."""
        now = self.read(lanes, self.values(lanes, np.zeros(len(lanes)))[0], 0)
        return self.observed(lanes, {**now, "finger_force_mean_n": np.zeros(len(lanes))})

    def values(self, lanes: NDArray[np.int64], asked: Floats) -> tuple[Floats, Floats]:
        """Returns the inputs of the keys over a period, and the positions of the fingertips after it."""
        asked = np.clip(asked, *CONTROLS[self.control])
        from_m = self.finger_m[lanes]
        if self.control == "force":
            return asked[:, np.newaxis], from_m
        to_m = np.clip(from_m + asked * self.period_s, *REACH_M)
        return np.stack([from_m, (to_m - from_m) / self.period_s], axis=1), to_m

    def step(self, lanes: NDArray[np.int64], asked: Floats) -> tuple[Floats, Floats, NDArray[np.bool_], NDArray[np.bool_], dict[str, Floats]]:
        """Plays a period of some lanes and returns observations, rewards, whether episodes ended, whether their time is
        over, and all readings."""
        values, to_m = self.values(lanes, asked)
        now = self.read(lanes, values, self.steps)
        self.finger_m[lanes] = to_m
        self.periods[lanes] += 1
        ended = (now["impact_count"] > 0) | (now["failed"] > 0)
        cut = ~ended & (self.periods[lanes] >= self.periods_max)
        self.over[lanes] = ended | cut
        rewards = np.asarray(self.reward(now, self.goal[lanes]), dtype=np.float64)
        return self.observed(lanes, now), rewards, ended, cut, now


def _action_of(value: Any, shape: tuple[int, ...]) -> Floats:
    """Returns the agent's action: an array of this shape; raises an error for numbers that are not finite."""
    found = np.shape(value)
    if found != shape:
        raise InputError(f"action: found shape {found}, expected {shape}", key="action", found=str(found), expected=str(shape))
    return floats("action", value, len(shape))


class KeyEnv(gymnasium.Env[Any, Any]):
    """One key of the grand, played by an agent. The agent pushes, observes key and hammer, and is to reach a given
    hammer speed at the string.

    Each step of the environment is one period of the agent. An episode ends at the impact, or when its time is over.
    With `control="force"`, an action is the force of the finger on the key, N, 0 to 60; with a `hand`, the force of the
    muscle on the hand. With "motion", it is the velocity of a soft fingertip, m/s, -1 to 1, down positive, and the
    fingertip stays within -20 to 30 mm; with a `hand`, the muscle follows it. Actions out of range are clipped. The
    same actions give the same bits as `Action.step`.

    Observations are eight numbers (`OBSERVED`): `key_m`, `key_m_per_s`, `finger_force_mean_n`, `hammer_rise_m`, `hammer_rise_m_per_s`, `finger_m`, `goal_m_per_s`,
    `time_s`. Key and finger are positive downward from the key's rest, the hammer upward. `info` holds the hammer speed
    at the impact, `hammer_speed_m_per_s` (total).

    `reset(options=...)` takes `state` (bytes from `Action.save` or `Keys.save`), `finger_m`, `goal_m_per_s` and
    `time_s`; `save` returns such options. To train repetition, begin episodes with a checked hammer.

    Parameters
    ----------
    instrument : Instrument or str
        Instrument of the key, e.g. "concert-grand" or "concert-grand-strings:key=52".
    control : {"force", "motion"}
        Quantity that the agent controls.
    hand : Hand, optional
        Hand between agent and key: a mass that the agent's muscle moves.
    period_s : float
        Period of the agent, s, 0.0001 to 0.1; the simulation's steps divide it evenly.
    duration_s : float
        Longest duration of an episode, s.
    goal_m_per_s : (float, float)
        Range of hammer speeds, m/s, from which each episode draws its goal uniformly.
    begin : bytes, optional
        State in which episodes begin, bytes from `Action.save` or `Keys.save`; by default at rest.
    reward : callable, optional
        Function of the readings after a period (arrays with one number for each lane) and of the goals, which returns
        the rewards; by default `speed_reward`.
    step : float, optional
        Longest step of the simulation, s.

    Examples
    --------
    >>> import gymnasium, erard.environments
    >>> env = gymnasium.make("erard/Key-v0")
    >>> observation, info = env.reset(seed=3, options={"goal_m_per_s": 2.0})
    >>> while True:
    ...     observation, reward, terminated, truncated, info = env.step([4.5])
    ...     if terminated or truncated:
    ...         break
    >>> terminated, 0.5 < info["hammer_speed_m_per_s"] < 5.0
    (True, True)
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        instrument: Instrument | str = "concert-grand",
        *,
        control: str = "force",
        hand: Hand | None = None,
        period_s: float = 1e-3,
        duration_s: float = 0.5,
        goal_m_per_s: tuple[float, float] = (0.5, 4.0),
        begin: bytes | None = None,
        reward: Reward | None = None,
        step: float | None = None,
        render_mode: None = None,
    ) -> None:
        own = [load(instrument) if isinstance(instrument, str) else instrument_of(instrument)]
        self._lanes = _Lanes(own, control, hand, period_s, duration_s, goal_m_per_s, begin, reward, 1, step)
        self.observation_space, self.action_space = self._lanes.spaces()
        self.render_mode = render_mode

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode.

        Parameters
        ----------
        seed : int, optional
            Seed of the goals that are drawn from now on.
        options : dict, optional
            Any of `state`, `finger_m`, `goal_m_per_s` and `time_s`.

        Returns
        -------
        observation : ndarray of shape (8,)
        info : dict
        """
        super().reset(seed=seed)
        options = options or {}
        goal = options["goal_m_per_s"] if "goal_m_per_s" in options else self.np_random.uniform(*self._lanes.goals)
        self._lanes.reset(0, goal, options)
        return self._lanes.present(_FIRST)[0], {}

    def step(self, action: Any) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Plays for one period.

        Parameters
        ----------
        action : array_like of shape (1,)
            Force, N, or velocity of the fingertip, m/s.

        Returns
        -------
        observation : ndarray of shape (8,)
        reward : float
        terminated : bool
            Whether the hammer reached the string, or a number became infinite.
        truncated : bool
            Whether the time is over.
        info : dict
            `hammer_speed_m_per_s` after an impact; `failed` if a number became infinite.
        """
        seen, rewards, ended, cut, now = self._lanes.step(_FIRST, _action_of(action, (1,)))
        info: dict[str, Any] = {}
        if now["impact_count"][0] > 0:
            info["hammer_speed_m_per_s"] = float(now["hammer_speed_m_per_s"][0])
        if now["failed"][0] > 0:
            info["failed"] = True
        return seen[0], float(rewards[0]), bool(ended[0]), bool(cut[0]), info

    def save(self) -> dict[str, Any]:
        """Returns the options with which `reset(options=...)` continues from here, to the bit.

        Returns
        -------
        dict
        """
        return self._lanes.saved(0)


class KeyVectorEnv(VectorEnv[Any, Any, Any]):
    """Many keys side by side, stepped on all cores without Python's lock. Each has the same bits as a separate
    `KeyEnv`.

    If the episode of a lane has ended, the lane begins the next episode in the following step and ignores the action of
    that step (Gymnasium's `AutoresetMode.NEXT_STEP`).

    Parameters
    ----------
    num_envs : int
        Number of lanes.
    instrument : Instrument, str, or sequence of Instrument
        One instrument for all lanes, or one for each.
    threads : int, optional
        Number of threads; by default the number of cores.
    control, hand, period_s, duration_s, goal_m_per_s, begin, reward, step
        As in `KeyEnv`.

    Examples
    --------
    >>> import gymnasium, numpy, erard.environments
    >>> envs = gymnasium.make_vec("erard/Key-v0", num_envs=64)
    >>> observations, infos = envs.reset(seed=1)
    >>> observations, rewards, terminated, truncated, infos = envs.step(numpy.full((64, 1), 6.0))
    >>> observations.shape
    (64, 8)
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        instrument: Instrument | str | Sequence[Instrument] = "concert-grand",
        *,
        control: str = "force",
        hand: Hand | None = None,
        period_s: float = 1e-3,
        duration_s: float = 0.5,
        goal_m_per_s: tuple[float, float] = (0.5, 4.0),
        begin: bytes | None = None,
        reward: Reward | None = None,
        threads: int | None = None,
        step: float | None = None,
        render_mode: None = None,
    ) -> None:
        self.num_envs = whole("num_envs", num_envs)
        if isinstance(instrument, (str, Instrument)):
            own = [load(instrument) if isinstance(instrument, str) else instrument] * self.num_envs
        else:
            own = [instrument_of(one) for one in instrument]
        if len(own) != self.num_envs:
            expected = f"one, or {self.num_envs}"
            raise InputError(f"instrument: found {len(own)} instruments, expected {expected}", key="instrument", found=str(len(own)))
        threads = None if threads is None else whole("threads", threads)
        self._lanes = _Lanes(own, control, hand, period_s, duration_s, goal_m_per_s, begin, reward, threads, step)
        self.single_observation_space, self.single_action_space = self._lanes.spaces()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._all, self._random = np.arange(self.num_envs), [np.random.default_rng() for _ in range(self.num_envs)]
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode in every lane.

        Parameters
        ----------
        seed : int or sequence of int, optional
            One seed for each lane, or the seed of the first lane; the others then get the numbers after it.
        options : dict, optional
            Options as in `KeyEnv.reset`; a list or an array has one value for each lane.

        Returns
        -------
        observations : ndarray of shape (N, 8)
        infos : dict
        """
        seeds = [None if seed is None else seed + lane for lane in range(self.num_envs)] if seed is None or isinstance(seed, int) else list(seed)
        if len(seeds) != self.num_envs:
            raise InputError(f"seed: found {len(seeds)}, expected one, or {self.num_envs}", key="seed", found=str(len(seeds)))
        for lane, own in enumerate(seeds):
            if own is not None:
                self._random[lane] = gymnasium.utils.seeding.np_random(own)[0]
            self._begin(lane, {name: _of_lane(name, value, lane, self.num_envs) for name, value in (options or {}).items()})
        return self._lanes.present(self._all), {}

    def _begin(self, lane: int, options: Mapping[str, Any]) -> None:
        goal = options["goal_m_per_s"] if "goal_m_per_s" in options else self._random[lane].uniform(*self._lanes.goals)
        self._lanes.reset(lane, goal, options)

    def step(self, actions: Any) -> tuple[Floats, Floats, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Plays for one period in every lane.

        Parameters
        ----------
        actions : array_like of shape (N, 1)
            Forces, N, or velocities of the fingertips, m/s.

        Returns
        -------
        observations : ndarray of shape (N, 8)
        rewards : ndarray of shape (N,)
        terminated, truncated : ndarray of shape (N,)
        infos : dict
            `hammer_speed_m_per_s` and `failed` of each lane, and masks of the lanes that have them, under the same
            names with a leading `_`.
        """
        asked = _action_of(actions, (self.num_envs, 1))[:, 0]
        lanes = self._lanes
        new, going = self._all[lanes.over], self._all[~lanes.over]
        seen, rewards = np.empty((self.num_envs, len(OBSERVED))), np.zeros(self.num_envs)
        terminated, truncated = np.zeros(self.num_envs, dtype=bool), np.zeros(self.num_envs, dtype=bool)
        infos: dict[str, Any] = {}
        if going.size:
            seen[going], rewards[going], terminated[going], truncated[going], now = lanes.step(going, asked[going])
            for name, is_there in (("hammer_speed_m_per_s", now["impact_count"] > 0), ("failed", now["failed"] > 0)):
                if is_there.any():
                    infos[name], infos[f"_{name}"] = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=bool)
                    infos[name][going[is_there]], infos[f"_{name}"][going[is_there]] = now[name][is_there], True
        if new.size:
            for lane in new.tolist():
                self._begin(lane, {})
            seen[new] = lanes.present(new)
        return seen, rewards, terminated, truncated, infos

    def save(self) -> dict[str, Any]:
        """Returns the options with which `reset(options=...)` continues from here, to the bit. They do not contain the
        goals of later episodes.

        Returns
        -------
        dict
        """
        saved = [self._lanes.saved(lane) for lane in range(self.num_envs)]
        return {name: [one[name] for one in saved] for name in saved[0]}


_FIRST = np.zeros(1, dtype=np.int64)


def _of_lane(name: str, value: Any, lane: int, count: int) -> Any:
    """Returns the option of one lane: its own, or the common one."""
    if isinstance(value, (bytes, str)) or np.ndim(value) == 0:
        return value
    if len(value) != count:
        raise InputError(f"{name}: found {len(value)} values, expected one, or {count}", key=name, found=str(len(value)))
    return value[lane]


gymnasium.register(
    id="erard/Key-v0", entry_point="erard.environments:KeyEnv", vector_entry_point="erard.environments:KeyVectorEnv"
)
