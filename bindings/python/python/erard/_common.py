"""Shared functions: conversion of arguments, progress bars, settings of the steps."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import numpy as np

from . import _erard
from ._errors import InputError, shortened

if TYPE_CHECKING:
    import os

    from numpy.typing import ArrayLike, NDArray

    from ._types import Floats, Progress, Steps


class Values(Mapping[str, Any]):
    """Read-only mapping of a result's keys, stored in `self._values`."""

    _values: dict[str, Any]

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


class Hand(NamedTuple):
    """Hand between stroke and key: a mass moved by a muscle, behind the instrument's soft fingertip.

    The stroke's force then acts as the muscle's force, or the muscle follows the stroke's motion. All default values
    are estimates.

    Parameters
    ----------
    mass_kg : float
        Effective mass at the fingertip, kg.
    stiffness_n_per_m, damping_n_s_per_m : float
        Stiffness and damping with which the muscle follows a motion, N/m and N s/m. They have no effect under a force.
    start_m, start_m_per_s : float
        Position and velocity of the hand at the start, m below the key front's rest and m/s, down positive.
    joints_m_per_n, joints_s : float, optional
        Compliance of the finger's joints, m/N, 0 to 0.1, in series with the fingertip, and their damping over their
        stiffness, s, 0 to 1. By default they are stiff, and those of the touch in a struck built-in touch.
    """

    mass_kg: float = 0.2
    stiffness_n_per_m: float = 1500.0
    damping_n_s_per_m: float = 14.0
    start_m: float = 0.0
    start_m_per_s: float = 0.0
    joints_m_per_n: float | None = None
    joints_s: float | None = None


class Stepping(TypedDict, total=False):
    """Settings of the steps: keyword arguments that every simulation takes.

    step : float
        Length of a step, s (default 50e-6, or 1/24000 with modal strings). While the hammer is near modal strings,
        steps are halved as often as needed.
    theta : float
        Parameter theta of the time-stepping scheme, 0.5 (second order) to 1 (damped); default 0.5.
    solver : str
        "active-set" (default) or "projected-gauss-seidel".
    friction : str
        "set-valued" (default: true dry friction) or "tanh" (regularised, kept for comparison).
    friction_width : float
        Width of the regularised law, rad/s (default 0.1).
    hand : Hand
        Hand between stroke and key; by default there is none and the stroke drives the key.
    """

    step: float | None
    theta: float
    solver: str
    friction: str
    friction_width: float
    hand: Hand | None


#: Settings of the steps that are names.
_CHOICES = {"solver": ("active-set", "projected-gauss-seidel"), "friction": ("set-valued", "tanh")}


def steps(given: Mapping[str, Any]) -> Steps:
    """Returns the settings as the extension takes them; raises a TypeError that names an unknown setting."""
    own: dict[str, Any] = {
        "step": None,
        "theta": 0.5,
        "solver": "active-set",
        "friction": "set-valued",
        "friction_width": 0.1,
        "hand": None,
    }
    for key, value in given.items():
        if key not in own:
            raise TypeError(f"unexpected argument {key!r}; how to step is said by {', '.join(own)}")
        if key == "hand":
            if not (value is None or isinstance(value, Hand)):
                raise refused("hand", value, "an erard.Hand")
            if value is not None:
                numbers: dict[str, Any] = {name: x if x is None else number(f"hand.{name}", x) for name, x in value._asdict().items()}
                own[key] = Hand(**numbers)
            continue
        if key == "step" and value is None:
            continue
        own[key] = choice(key, value, _CHOICES[key]) if key in _CHOICES else number(key, value)
    return own  # type: ignore[return-value]


def step_of(own: Steps, *usual_s: float) -> float:
    """Returns the step length, s: the given one, or the shortest default of the instruments."""
    step = own["step"]
    return min(usual_s) if step is None else step


def refused(key: str, found: Any, expected: str) -> InputError:
    """Returns the error of an argument that is not what is expected: every reader below refuses with it."""
    shown = shortened(repr(found))
    return InputError(f"{key}: found {shown}, expected {expected}", key=key, found=shown, expected=expected)


def flag(key: str, value: Any) -> bool:
    """Returns a truth value, or raises an error that names the argument: `single="no"` is a mistake, not yes."""
    if not isinstance(value, (bool, np.bool_)):
        raise refused(key, value, "True or False")
    return bool(value)


def text_of(key: str, value: Any, expected: str = "a text") -> str:
    """Returns a text, or raises an error that names the argument."""
    if not isinstance(value, str) or not _is_unicode(value):
        raise refused(key, value, expected)
    return value


def _is_unicode(value: str) -> bool:
    """Returns whether a text has a UTF-8 form; halves of surrogate pairs have none."""
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True


def items_of(key: str, values: Any, expected: str) -> list[Any]:
    """Returns the items of a list, or raises an error that names the argument: a text is no list of its letters."""
    if not isinstance(values, (str, bytes)):
        try:
            return list(values)
        except TypeError:
            pass
    raise refused(key, values, expected)


def choice(key: str, value: Any, names: Iterable[str]) -> str:
    """Returns one of these names, or raises an error that lists them."""
    names = tuple(names)
    if not isinstance(value, str) or value not in names:
        raise refused(key, value, " or ".join(filter(None, [", ".join(names[:-1]), names[-1]])))
    return value


def path_of(key: str, value: str | os.PathLike[str], expected: str = "a text or a path") -> str:
    """Returns a path as a text, or raises an error that names the argument."""
    found = value if isinstance(value, str) else getattr(type(value), "__fspath__", lambda _: None)(value)
    if not isinstance(found, str) or "\0" in found:
        raise refused(key, value, expected)
    return found


def key_of(key: str, value: Any) -> int | str:
    """Returns a key of the piano by number or note, or raises an error that names the argument."""
    if isinstance(value, str) and _is_unicode(value):
        return value
    try:
        return whole(key, value, 0)
    except InputError:
        raise refused(key, value, "the number of a key, from 1, or its note, as in 'C4'") from None


def saved_of(value: Any) -> bytes:
    """Returns the bytes of a saved state, or raises an error."""
    if not isinstance(value, (bytes, bytearray, memoryview)):
        raise refused("saved", value, "bytes, as `save` returns them")
    return bytes(value)


def number(key: str, value: Any) -> float:
    """Returns a finite number, or raises an error that names the argument. A bool is no number: `force=True` is a
    mistake, not 1 N."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise refused(key, value, "a number") from None
    if not np.isfinite(found):
        raise refused(key, found, "a finite number")
    return found


def value_of(key: str, value: Any) -> float | str:
    """Returns a number, or a text that the extension reads as one, or raises an error that names the argument."""
    return text_of(key, value, "a text in Unicode") if isinstance(value, str) else number(key, value)


#: Largest integer of the extension.
_LARGEST = 2**63 - 1


def whole(key: str, value: Any, least: int = 1) -> int:
    """Returns a whole number, `least` or more, or raises an error that names the argument."""
    try:
        found = least - 1 if isinstance(value, (bool, np.bool_)) else operator.index(value)
    except TypeError:
        found = least - 1
    if not least <= found <= _LARGEST:
        raise refused(key, value, f"a whole number from {least}")
    return found


def names_of(key: str, values: Iterable[str] | None) -> list[str]:
    """Returns a list of names; raises an error for a single text, which is not a list of its letters."""
    if values is None:
        return []
    expected = f"a list of names, as in [{shortened(repr(values))}]" if isinstance(values, str) else "a list of names"
    return [text_of(key, value, "a list of names") for value in items_of(key, values, expected)]


def mapping(key: str, value: Any) -> Mapping[Any, Any]:
    """Returns a mapping of names, empty for `None`, or raises an error that names the argument."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise refused(key, value, "a mapping of names to values")
    return value


def pair(key: str, value: Any) -> tuple[float, float] | None:
    """Returns position and velocity, `None` for `None`, or raises an error that names the argument."""
    if value is None:
        return None
    if isinstance(value, (str, bytes)) or np.shape(value) != (2,):
        raise refused(key, value, "two numbers, m and m/s")
    position, velocity = unmasked(key, value)
    return number(f"{key}[0]", position), number(f"{key}[1]", velocity)


def _told(progress: Any) -> bool | None:
    """Returns whether to show progress; raises an error for anything but a bool or `None`."""
    if progress is None or isinstance(progress, (bool, np.bool_)):
        return None if progress is None else bool(progress)
    raise refused("progress", progress, "True, False or None")


def unmasked(key: str, values: Any) -> Any:
    """Returns the values; raises an error if any is masked, because nothing says what replaces it."""
    if np.ma.is_masked(values):
        count = int(np.count_nonzero(values.mask))
        hidden = f"{count} masked value{'s' if count > 1 else ''}"
        raise InputError(
            f"{key}: found {hidden}, expected numbers everywhere (the array's `filled` or `compressed` decides what replaces them)",
            key=key,
            found=hidden,
        )
    return values


def real(values: Any) -> NDArray[np.float64]:
    """Returns a contiguous array of doubles; raises a TypeError or ValueError for complex or non-numeric values."""
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise TypeError("complex numbers")
    if array.dtype.kind == "b":
        raise TypeError("truth values")
    return np.asarray(array, dtype=np.float64, order="C")


def floats(key: str, values: ArrayLike, dimensions: int) -> Floats:
    """Returns a contiguous, finite array of doubles with this number of dimensions, or raises an error."""
    values = unmasked(key, values)
    try:
        array = real(values)
    except (TypeError, ValueError, OverflowError):
        kind = repr(values) if isinstance(values, str) else f"{type(values).__name__} of {np.asarray(values).dtype}"
        raise InputError(f"{key}: found {kind}, expected an array of numbers", key=key, found=kind) from None
    shape = f"an array of shape {array.shape}" if array.ndim else "a single number"
    if array.ndim != dimensions:
        expected = f"an array of {dimensions} dimension{'s' if dimensions > 1 else ''}"
        raise InputError(f"{key}: found {shape}, expected {expected}", key=key, found=shape, expected=expected)
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        at = tuple(int(i) for i in np.unravel_index(bad[0], array.shape))
        where = at[0] if len(at) == 1 else at
        found = str(array[at])
        raise InputError(f"{key}: sample {where} is {found}; expected finite numbers", key=key, found=found)
    return array


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Makes the array read-only and returns it."""
    array.flags.writeable = False
    return array


def _tqdm() -> Any:
    """Returns tqdm's automatic bar. Without notebook widgets it is the plain bar; the warning about that is
    silenced."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from tqdm.auto import tqdm
    return tqdm


@contextmanager
def bar(progress: bool | None, what: str) -> Iterator[Progress]:
    """Yields a function that takes the share done. With `None`, a bar appears on a terminal or in a notebook after a
    second."""
    progress = _told(progress)
    if progress is False:
        yield None
        return
    shown = _tqdm()(
        total=100,
        desc=what,
        delay=0.0 if progress else 1.0,
        disable=False if progress else None,
        leave=bool(progress),
        bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}",
    )

    def tell(share: float) -> None:
        shown.update(100.0 * min(max(share, 0.0), 1.0) - shown.n)

    try:
        yield tell
    finally:
        shown.close()


@contextmanager
def counter(progress: bool | None, what: str, unit: str) -> Iterator[Callable[[int], None] | None]:
    """Yields a function that takes the number of items newly done, for work of unknown total. `None` is as in `bar`."""
    progress = _told(progress)
    if progress is False:
        yield None
        return
    shown = _tqdm()(desc=what, unit=f" {unit}", delay=0.0 if progress else 1.0, disable=False if progress else None, leave=bool(progress))

    def tell(more: int) -> None:
        shown.update(more)

    try:
        yield tell
    finally:
        shown.close()


def quantity(value: float | None, unit: str, digits: int = 4) -> str:
    """Returns a number with its unit as text; a dash for `None`."""
    return "-" if value is None else f"{value:.{digits}g} {unit}".rstrip()


def unit_of(column: str) -> str:
    """Returns the unit of a column, from the ending of its name.

    Parameters
    ----------
    column : str
        Name of the column, such as "key_m".

    Returns
    -------
    str
        Unit; "1" for a number without unit.

    Examples
    --------
    >>> from erard import unit_of
    >>> unit_of("hammer_rad_per_s"), unit_of("key_m")
    ('rad/s', 'm')
    """
    return _erard.unit(text_of("column", column, "the name of a column"))
