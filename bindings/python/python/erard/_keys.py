"""The keys of a keyboard, played together."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Unpack

from . import _erard
from ._common import Stepping, number, pair, steps

if TYPE_CHECKING:
    from ._erard import Reading


class Keys:
    """The 88 keys of a keyboard at rest, stepped together. A key that is at rest costs nothing until something moves it.

    Keys count from 1, the lowest A. A key's drive holds until it is given another. Two threads may step one keyboard: one waits for the other.

    Parameters
    ----------
    keyboard : str or path-like
        A built-in keyboard ("concert-grand", or "concert-grand-strings", whose strings sound) or a TOML file.
    **how
        How to step, as `Action` takes it. With `hand`, a `Hand`, each key has a hand of its own.

    Examples
    --------
    >>> import erard
    >>> keys = erard.Keys("concert-grand-strings")
    >>> for key in (40, 44, 47):  # C4, E4, G4
    ...     keys.drive(key, force=5.0)
    >>> sorted(key for key, time_s, speed in keys.step(2400))  # a tenth of a second
    [40, 44, 47]
    >>> abs(keys.reading(40).bridge_n) > 0.0
    True
    """

    def __init__(self, keyboard: str | os.PathLike[str] = "concert-grand", **how: Unpack[Stepping]) -> None:
        self._inner = _erard.Keys(os.fspath(keyboard), steps(how))

    def __len__(self) -> int:
        """Number of keys."""
        return self._inner.count()

    @property
    def awake(self) -> int:
        """Number of keys that are awake: only those cost time."""
        return self._inner.awake()

    @property
    def step_s(self) -> float:
        """Length of a step, s."""
        return self._inner.step_s()

    @property
    def time_s(self) -> float:
        """The present instant, s; new keys are at 0."""
        return self._inner.time_s()

    def drive(
        self,
        key: int,
        force: float | None = None,
        *,
        motion: tuple[float, float] | None = None,
        rigid: tuple[float, float] | None = None,
    ) -> None:
        """Drives a key from the next step on, until it is driven otherwise.

        Parameters
        ----------
        key : int
            From 1.
        force, motion, rigid
            As in `Action.step`; without any of them nothing touches the key.
        """
        self._inner.drive(key, None if force is None else number("force", force), pair("motion", motion), pair("rigid", rigid))

    def place_hand(self, key: int, position_m: float, velocity_m_per_s: float = 0.0) -> None:
        """Places the hand of a key.

        Parameters
        ----------
        key : int
            From 1.
        position_m : float
            m below the key front's rest; negative in the air.
        velocity_m_per_s : float
            m/s, down positive.

        Raises
        ------
        InputError
            Where the keys have no hands, or there is no such key.
        """
        self._inner.place_hand(key, number("position_m", position_m), number("velocity_m_per_s", velocity_m_per_s))

    def set_pedal(self, lift_m: float) -> None:
        """Sends the sustain pedal's rail to a lift, under all keys. Without modal strings it does nothing.

        Parameters
        ----------
        lift_m : float
            m, from 0 to 0.010; the rail moves at 0.5 m/s at most.
        """
        self._inner.set_pedal(number("lift_m", lift_m))

    def step(self, steps: int = 1) -> list[tuple[int, float, float]]:
        """Takes steps.

        Parameters
        ----------
        steps : int
            How many.

        Returns
        -------
        list of (int, float, float)
            The impacts in these steps, in their order: key, instant, s, and speed of the hammer at the string, m/s.
        """
        return self._inner.step(steps)

    def reading(self, key: int) -> Reading:
        """The reading of a key after the last step.

        Parameters
        ----------
        key : int
            From 1.

        Returns
        -------
        Reading
            As `Action.step` gives it; where the key rests, that of its last step.
        """
        return self._inner.reading(key)

    @property
    def bridge_n(self) -> float:
        """Force of the strings of all keys on the bridge now, N, with what the dampers at rest press; 0 where none sound."""
        return self._inner.bridge_n()

    def save(self, key: int) -> bytes:
        """All that a key's next steps depend on, but for its drive. An `Action` of the key's instrument goes on from there, too, and the other way round.

        Parameters
        ----------
        key : int
            From 1.

        Returns
        -------
        bytes
        """
        return self._inner.save(key)

    def restore(self, key: int, saved: bytes) -> None:
        """A key goes on from a saved state of the same instrument, to the bit; its drive stays.

        Parameters
        ----------
        key : int
            From 1.
        saved : bytes
            What `save` gave, here or of an `Action`.

        Raises
        ------
        InputError
            Where the bytes are of another instrument, or are no state; nothing has changed then.
        """
        self._inner.restore(key, saved)

    def __repr__(self) -> str:
        return f"<erard.Keys: {len(self)} keys, {self.awake} awake, {self.time_s:.6f} s>"
