"""The keys of a keyboard, stepped together."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Unpack

from . import _erard
from ._common import Stepping, key_of, number, pair, path_of, saved_of, whole
from ._common import steps as settings

if TYPE_CHECKING:
    from ._erard import Reading


class Keys:
    """The 88 keys of a keyboard, starting at rest and stepped together. A key at rest takes no computing time.

    Keys count from 1, the lowest A. Each key keeps its drive until you set another. Two threads may step one keyboard:
    one waits for the other.

    Parameters
    ----------
    keyboard : str or path-like
        A built-in keyboard ("concert-grand", or "concert-grand-strings" with modal strings) or a TOML file.
    **how
        Settings of the steps, as for `Action`. With `hand`, a `Hand`, each key has its own hand.

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
        self._inner = _erard.Keys(path_of("keyboard", keyboard, "the name of a keyboard or the path of its file"), settings(how))

    def __len__(self) -> int:
        """Number of keys."""
        return self._inner.count()

    @property
    def awake(self) -> int:
        """Number of keys that are awake, which are those that take computing time."""
        return self._inner.awake()

    @property
    def step_s(self) -> float:
        """Length of a step, s."""
        return self._inner.step_s()

    @property
    def time_s(self) -> float:
        """Present time, s; new keys start at 0."""
        return self._inner.time_s()

    def drive(
        self,
        key: int | str,
        force: float | None = None,
        *,
        motion: tuple[float, float] | None = None,
        rigid: tuple[float, float] | None = None,
    ) -> None:
        """Sets the drive of a key from the next step on, until you set another.

        Parameters
        ----------
        key : int or str
            Key, by number from 1 or by note, such as "C4".
        force, motion, rigid
            As in `Action.step`; without any of them, nothing touches the key.
        """
        self._inner.drive(key_of("key", key), None if force is None else number("force", force), pair("motion", motion), pair("rigid", rigid))

    def place_hand(self, key: int | str, position_m: float, velocity_m_per_s: float = 0.0) -> None:
        """Places the hand of a key.

        Parameters
        ----------
        key : int or str
            Key, by number from 1 or by note, such as "C4".
        position_m : float
            Position, m below the key front's rest; negative above the key.
        velocity_m_per_s : float
            Velocity, m/s, down positive.

        Raises
        ------
        InputError
            If the keys have no hands, or there is no such key.
        """
        self._inner.place_hand(key_of("key", key), number("position_m", position_m), number("velocity_m_per_s", velocity_m_per_s))

    def set_pedal(self, lift_m: float) -> None:
        """Sets the target lift of the sustain pedal's rail, under all keys. Without modal strings it has no effect.

        Parameters
        ----------
        lift_m : float
            Lift, m, 0 to 0.010; values outside are clamped. The rail moves at no more than 0.5 m/s.
        """
        self._inner.set_pedal(number("lift_m", lift_m))

    def step(self, steps: int = 1) -> list[tuple[int, float, float]]:
        """Takes steps of all keys that are awake.

        Parameters
        ----------
        steps : int
            Number of steps.

        Returns
        -------
        list of (int, float, float)
            Impacts in these steps, in the order of the steps: key, time (s) and hammer speed at the string (m/s,
            total).
        """
        return self._inner.step(whole("steps", steps, 0))

    def reading(self, key: int | str) -> Reading:
        """Returns the reading of a key after the last step.

        Parameters
        ----------
        key : int or str
            Key, by number from 1 or by note, such as "C4".

        Returns
        -------
        Reading
            Reading as from `Action.step`; for a key at rest, that of its last step.
        """
        return self._inner.reading(key_of("key", key))

    @property
    def bridge_n(self) -> float:
        """Present force of all keys' strings on the bridge, N, including the load of the dampers at rest; 0 without
        modal strings."""
        return self._inner.bridge_n()

    def save(self, key: int | str) -> bytes:
        """Returns the complete state of a key, without its drive. `Action` and `Keys` can restore each other's states
        of the same instrument.

        Parameters
        ----------
        key : int or str
            Key, by number from 1 or by note, such as "C4".

        Returns
        -------
        bytes
        """
        return self._inner.save(key_of("key", key))

    def restore(self, key: int | str, saved: bytes) -> None:
        """Restores a saved state of a key; its drive stays. The key then continues with the same bits.

        Parameters
        ----------
        key : int or str
            Key, by number from 1 or by note, such as "C4".
        saved : bytes
            Bytes that `save` returned, here or of an `Action`.

        Raises
        ------
        InputError
            If the bytes belong to another instrument or are not a saved state; the key is then unchanged.
        """
        self._inner.restore(key_of("key", key), saved_of(saved))

    def __repr__(self) -> str:
        return f"<erard.Keys: {len(self)} keys, {self.awake} awake, {self.time_s:.6f} s>"
