"""An action that is stepped from outside."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Unpack

from . import _erard
from ._common import Stepping, floats, number, pair, steps
from ._instrument import instrument_of
from ._table import Table

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._erard import Reading
    from ._instrument import Instrument


class Action:
    """A grand action at rest, stepped one step at a time: a force or a position goes in, what the mechanism does comes out.

    Two threads may step one action: one waits for the other. It pickles with its state, and goes on to the bit.

    Parameters
    ----------
    instrument : Instrument
    **how
        How to step: `step` (s, default 50e-6, and 1/24000 where strings sound), `theta`, `solver`, `friction`, `friction_width`; and `hand`, a `Hand`: force and motion are
        then what its muscle does.

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
        """The instrument that is played."""
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
        """Takes a step.

        Parameters
        ----------
        force : float, optional
            Of the finger, N, pushing positive.
        motion : (float, float), optional
            Where a soft fingertip is, m down from the key's rest, and its velocity, m/s.
        rigid : (float, float), optional
            The same of the key's front itself, imposed. Without any of the three nothing touches the key.

        Returns
        -------
        Reading
            `time_s`, `key_m`, `key_m_per_s`, `finger_n` (force of the finger on the key), `hammer_m`, `hammer_m_per_s` (up positive), `string_n`,
            `hand_m` and `hand_m_per_s` (the hand, where there is one), `bridge_n` (force of the strings on the bridge, where they sound), `converged`, and `impact`: instant (s) and hammer speed (m/s) of the impact in this step, else `None`.
        """
        return self._inner.step(None if force is None else number("force", force), pair("motion", motion), pair("rigid", rigid))

    def place_hand(self, position_m: float, velocity_m_per_s: float = 0.0) -> None:
        """Places the hand of an action that was made with one.

        Parameters
        ----------
        position_m : float
            m below the key front's rest; negative in the air.
        velocity_m_per_s : float
            m/s, down positive.

        Raises
        ------
        InputError
            Where the action has no hand, or a number is not finite.
        """
        self._inner.place_hand(number("position_m", position_m), number("velocity_m_per_s", velocity_m_per_s))

    def set_pedal(self, lift_m: float) -> None:
        """Sends the rail that the sustain pedal lifts to a lift. Without modal strings it does nothing.

        Parameters
        ----------
        lift_m : float
            m, from 0 to 0.010; the rail moves at 0.5 m/s at most.
        """
        self._inner.set_pedal(number("lift_m", lift_m))

    def play(self, force: ArrayLike) -> Table:
        """Takes a step for each force.

        Parameters
        ----------
        force : array_like of shape (T,)
            N, one for each step.

        Returns
        -------
        Table
            Columns of shape (T,): `time_s`, `key_m`, `hammer_head_m`, `hammer_head_m_per_s`, `string_N`.
        """
        return Table(dict(self._inner.play(floats("force", force, 1))))

    @property
    def reading(self) -> Reading:
        """The present reading."""
        return self._inner.reading()

    @property
    def time_s(self) -> float:
        """The present instant, s; a new action is at 0."""
        return self._inner.reading().time_s

    @property
    def angles(self) -> dict[str, float]:
        """Absolute angles of the bodies, rad, counter-clockwise."""
        return dict(zip(self._instrument.bodies, map(float, self._inner.angles()), strict=True))

    @property
    def velocities(self) -> dict[str, float]:
        """Absolute angular velocities of the bodies, rad/s."""
        return dict(zip(self._instrument.bodies, map(float, self._inner.velocities()), strict=True))

    @property
    def contact_forces(self) -> dict[str, float]:
        """Normal forces of the contacts in the last step, N."""
        return dict(zip(self._instrument.zones, map(float, self._inner.contact_forces()), strict=True))

    def save(self) -> bytes:
        """All that the next steps depend on: the same bytes on every machine.

        They belong to the instrument's numbers that change a step. Its name, its notes and the order in its file do not count.

        Returns
        -------
        bytes
        """
        return self._inner.save()

    def restore(self, saved: bytes) -> None:
        """Goes on from a saved state of the same instrument, to the bit.

        Parameters
        ----------
        saved : bytes
            What `save` gave.

        Raises
        ------
        InputError
            Where the bytes are of another instrument, or are no state; nothing has changed then.
        """
        self._inner.restore(saved)

    def __eq__(self, other: object) -> bool:
        """Whether all that the next steps depend on is the same."""
        if not isinstance(other, Action):
            return NotImplemented
        return self._instrument == other._instrument and self._steps == other._steps and self.save() == other.save()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        now = self.reading
        key, hammer = 1e3 * now.key_m, 1e3 * now.hammer_m
        return f"<erard.Action of {self._instrument.name}, {now.time_s:.6f} s: key {key:.3f} mm down, hammer {hammer:.3f} mm up>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._instrument, dict(self._steps), self.save())


def _unpickled(instrument: Instrument, how: dict[str, Any], saved: bytes) -> Action:
    action = Action(instrument, **how)
    action.restore(saved)
    return action
