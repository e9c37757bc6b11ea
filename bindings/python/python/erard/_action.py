"""Actions that the caller steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Unpack

from . import _erard
from ._common import Stepping, floats, number, pair, saved_of, steps
from ._instrument import instrument_of
from ._table import Table

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._erard import Reading
    from ._instrument import Instrument


class Action:
    """Grand action, starting at rest, that you step: each step takes a force or a position and returns a reading.

    Two threads may step one action: one waits for the other. Pickling keeps the state; an unpickled action continues
    with the same bits.

    Parameters
    ----------
    instrument : Instrument
    **how
        Settings of the steps: `step` (s, default 50e-6, or 1/24000 with modal strings), `theta`, `solver`, `friction`,
        `friction_width`; and `hand`, a `Hand`, whose muscle force and motion then drives.

    Examples
    --------
    >>> import erard
    >>> action = erard.Action(erard.load("concert-grand"))
    >>> for _ in range(2000):
    ...     reading = action.step(force=4.5)
    ...     if reading.impact:
    ...         break
    >>> 0.5 < reading.impact[1] < 5.0
    True
    """

    def __init__(self, instrument: Instrument, **how: Unpack[Stepping]) -> None:
        self._instrument, self._steps = instrument_of(instrument), steps(how)
        self._inner = _erard.Action(instrument._inner, self._steps)

    @property
    def instrument(self) -> Instrument:
        """Instrument of the action."""
        return self._instrument

    @property
    def step_s(self) -> float:
        """Length of a step, s."""
        return self._inner.step_s()

    def step(
        self,
        force: float | None = None,
        *,
        motion: tuple[float, float] | None = None,
        rigid: tuple[float, float] | None = None,
    ) -> Reading:
        """Takes one step. Without any of the three arguments, nothing touches the key.

        Parameters
        ----------
        force : float, optional
            Force of the finger, N, pushing positive.
        motion : (float, float), optional
            Position of a soft fingertip, m down from the key's rest, and its velocity, m/s, in the middle of the step.
        rigid : (float, float), optional
            Prescribed position of the key front itself, m down from rest, and its velocity, m/s, at the end of the
            step.

        Returns
        -------
        Reading
            `time_s`, `key_m`, `key_m_per_s`, `finger_force_n` (force of the finger on the key), `hammer_rise_m`,
            `hammer_rise_m_per_s` (up positive), `string_n`, `hand_m` and `hand_m_per_s` (with a hand), `bridge_n`
            (force of modal strings on the bridge), `converged`, and `impact`: time (s) and hammer speed (m/s, total) of
            the impact in this step, or `None`.
        """
        return self._inner.step(None if force is None else number("force", force), pair("motion", motion), pair("rigid", rigid))

    def place_hand(self, position_m: float, velocity_m_per_s: float = 0.0) -> None:
        """Places the hand of an action that has a `hand`.

        Parameters
        ----------
        position_m : float
            Position, m below the key front's rest; negative above the key.
        velocity_m_per_s : float
            Velocity, m/s, down positive.

        Raises
        ------
        InputError
            If the action has no hand, or a number is not finite.
        """
        self._inner.place_hand(number("position_m", position_m), number("velocity_m_per_s", velocity_m_per_s))

    def set_pedal(self, lift_m: float) -> None:
        """Sets the target lift of the sustain pedal's rail. Without modal strings it has no effect.

        Parameters
        ----------
        lift_m : float
            Lift, m, 0 to 0.010; values outside are clamped. The rail moves at no more than 0.5 m/s.
        """
        self._inner.set_pedal(number("lift_m", lift_m))

    def play(self, force: ArrayLike, *, dt: float | None = None) -> Table:
        """Takes one step for each force; with `dt`, plays a sampled force.

        Parameters
        ----------
        force : array_like of shape (T,)
            Force of the finger, N, pushing positive. Without `dt`: in each step, constant during the step. With `dt`:
            samples `dt` apart from the present instant on. Between samples the force is interpolated as in
            `Instrument.press`, `rollout` and stroke files of the command: by monotone cubics (Fritsch and Carlson),
            which are smooth and never outside two neighbouring samples.
        dt : float, optional
            Time between samples, s.

        Returns
        -------
        Table
            Columns with one row for each step: `time_s`, `key_m`, `hammer_rise_m`, `hammer_rise_m_per_s`, `string_N`.
            With `dt` these are the steps that end by the last sample, at (T - 1) dt.

        Raises
        ------
        InputError
            If a force or `dt` is out of range, or fewer than two samples are given with `dt`.

        Examples
        --------
        >>> import erard, numpy as np
        >>> grand = erard.load("concert-grand")
        >>> force = np.array([0.0, 2.0, 6.0, 5.0, 5.0])
        >>> played = erard.Action(grand).play(force, dt=10e-3)
        >>> rolled = erard.rollout(grand, force=force[None], dt=10e-3)
        >>> len(played["key_m"]), bool(np.allclose(played["key_m"][199::200], rolled["key_m"][0, 1:], rtol=1e-9))
        (800, True)
        """
        dt = None if dt is None else number("dt", dt)
        return Table(dict(self._inner.play(floats("force", force, 1), dt)))

    @property
    def reading(self) -> Reading:
        """Reading of the present state."""
        return self._inner.reading()

    @property
    def time_s(self) -> float:
        """Present time, s; a new action starts at 0."""
        return self._inner.reading().time_s

    @property
    def angles(self) -> dict[str, float]:
        """Absolute angles of the bodies, rad, counter-clockwise positive."""
        return dict(zip(self._instrument.bodies, map(float, self._inner.angles()), strict=True))

    @property
    def velocities(self) -> dict[str, float]:
        """Absolute angular velocities of the bodies, rad/s, counter-clockwise positive."""
        return dict(zip(self._instrument.bodies, map(float, self._inner.velocities()), strict=True))

    @property
    def contact_forces(self) -> dict[str, float]:
        """Normal forces of the contact zones in the last step, N, never negative."""
        return dict(zip(self._instrument.zones, map(float, self._inner.contact_forces()), strict=True))

    def save(self) -> bytes:
        """Returns the complete state as bytes, which are the same on every machine.

        The state fits every instrument whose parameters that affect a step are the same; name, notes and order in the
        file may differ.

        Returns
        -------
        bytes
        """
        return self._inner.save()

    def restore(self, saved: bytes) -> None:
        """Restores a saved state of the same instrument; the action then continues with the same bits.

        Parameters
        ----------
        saved : bytes
            Bytes that `save` returned.

        Raises
        ------
        InputError
            If the bytes belong to another instrument or are not a saved state; the action is then unchanged.
        """
        self._inner.restore(saved_of(saved))

    def __eq__(self, other: object) -> bool:
        """Whether instrument, settings and state are equal."""
        if not isinstance(other, Action):
            return NotImplemented
        return self._instrument == other._instrument and self._steps == other._steps and self.save() == other.save()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        now = self.reading
        key, hammer = 1e3 * now.key_m, 1e3 * now.hammer_rise_m
        return f"<erard.Action of {self._instrument.name}, {now.time_s:.6f} s: key {key:.3f} mm down, hammer {hammer:.3f} mm up>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._instrument, dict(self._steps), self.save())


def _unpickled(instrument: Instrument, how: dict[str, Any], saved: bytes) -> Action:
    action = Action(instrument, **how)
    action.restore(saved)
    return action
