"""Helpers that the modules share: arguments made into arrays, progress bars, the settings of the steps."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import numpy as np

from . import _erard
from ._errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._types import Floats, Progress, Steps


class Values(Mapping[str, Any]):
    """A mapping of an answer's keys, `self._values`, which is not changed."""

    _values: dict[str, Any]

    def __getitem__(self, key: str) -> Any:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


class Hand(NamedTuple):
    """A hand between stroke and key: a mass that muscle moves, behind the instrument's soft fingertip.

    The stroke's force is then the muscle's, or the muscle follows the stroke's motion. All numbers are estimates.

    Parameters
    ----------
    mass_kg : float
        Effective mass at the fingertip, kg.
    stiffness_n_per_m, damping_n_s_per_m : float
        With which muscle follows a motion, N/m and N s/m. Without effect under a force.
    start_m, start_m_per_s : float
        Where the hand is at first, m below the key front's rest, and how fast, m/s, down positive.
    """

    mass_kg: float = 0.2
    stiffness_n_per_m: float = 1500.0
    damping_n_s_per_m: float = 14.0
    start_m: float = 0.0
    start_m_per_s: float = 0.0


class Stepping(TypedDict, total=False):
    """How to step: keyword arguments that every simulation takes.

    step : float
        Length of a step, s (default 50e-6, and 1/24000 where strings sound). It is halved as often as needed while the hammer is near strings that
        sound.
    theta : float
        Of the time-stepping scheme, 0.5 (second order) to 1 (damped); default 0.5.
    solver : str
        "active-set" (default) or "projected-gauss-seidel".
    friction : str
        "set-valued" (default: true dry friction) or "tanh" (regularised, kept for comparison).
    friction_width : float
        Width of the regularised law, rad/s (default 0.1).
    hand : Hand
        The hand between stroke and key; default none: the stroke drives the key.
    """

    step: float | None
    theta: float
    solver: str
    friction: str
    friction_width: float
    hand: Hand | None


def steps(given: Mapping[str, Any]) -> Steps:
    """The settings as the extension takes them; what is unknown is named."""
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
                raise InputError(f"hand: found {value!r}, expected an erard.Hand", key="hand", found=repr(value))
            own[key] = None if value is None else Hand(*(number(f"hand.{name}", x) for name, x in value._asdict().items()))
            continue
        if key == "step" and value is None:
            continue
        own[key] = value if isinstance(own[key], str) else number(key, value)
    return own  # type: ignore[return-value]


def step_of(own: Steps, *usual_s: float) -> float:
    """Length of a step, s: the one that is asked for, else the shortest of the instruments' usual ones."""
    step = own["step"]
    return min(usual_s) if step is None else step


def number(key: str, value: Any) -> float:
    """A finite number, or an error that names the argument."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{key}: found {value!r}, expected a number", key=key, found=repr(value)) from None
    if not np.isfinite(found):
        raise InputError(f"{key}: found {found}, expected a finite number", key=key, found=str(found))
    return found


#: What the extension counts with.
_LARGEST = 2**63 - 1


def whole(key: str, value: Any, least: int = 1) -> int:
    """A whole number from `least` on, or an error that names the argument."""
    try:
        found = operator.index(value)
    except TypeError:
        found = least - 1
    if not least <= found <= _LARGEST:
        raise InputError(f"{key}: found {value!r}, expected a whole number from {least}", key=key, found=repr(value))
    return found


def names_of(key: str, values: Iterable[str] | None) -> list[str]:
    """A list of names; one alone is no list of its letters."""
    if isinstance(values, str):
        raise InputError(f"{key}: found {values!r}, expected a list of names, as in [{values!r}]", key=key, found=values)
    if values is None:
        return []
    if not isinstance(values, Iterable):
        raise InputError(f"{key}: found {values!r}, expected a list of names", key=key, found=repr(values))
    return [str(value) for value in values]


def mapping(key: str, value: Any) -> Mapping[Any, Any]:
    """A mapping of names, or an error that names the argument; `None` is an empty one."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(f"{key}: found {value!r}, expected a mapping of names to values", key=key, found=repr(value))
    return value


def pair(key: str, value: Any) -> tuple[float, float] | None:
    """Position and velocity, or an error that names the argument; `None` is nothing."""
    if value is None:
        return None
    if isinstance(value, (str, bytes)) or np.shape(value) != (2,):
        raise InputError(f"{key}: found {value!r}, expected two numbers, m and m/s", key=key, found=repr(value))
    position, velocity = unmasked(key, value)
    return number(f"{key}[0]", position), number(f"{key}[1]", velocity)


def _told(progress: Any) -> bool | None:
    """Whether progress is shown, or an error: an array is neither."""
    if progress is None or isinstance(progress, (bool, np.bool_)):
        return None if progress is None else bool(progress)
    raise InputError(f"progress: found {progress!r}, expected True, False or None", key="progress", found=repr(progress))


def unmasked(key: str, values: Any) -> Any:
    """The values; masked ones are an error, for nothing else says what stands in their place."""
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
    """An array of doubles, contiguous. What is complex or no number is a TypeError or a ValueError."""
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise TypeError("complex numbers")
    return np.asarray(array, dtype=np.float64, order="C")


def floats(key: str, values: ArrayLike, dimensions: int) -> Floats:
    """An array of doubles of so many dimensions, contiguous and finite."""
    values = unmasked(key, values)
    try:
        array = real(values)
    except (TypeError, ValueError):
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
    """The array, read-only."""
    array.flags.writeable = False
    return array


def _tqdm() -> Any:
    """tqdm's own choice of a bar. In a notebook without widgets it takes the plain one, and need not say so."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from tqdm.auto import tqdm
    return tqdm


@contextmanager
def bar(progress: bool | None, what: str) -> Iterator[Progress]:
    """A function that takes the share done. `None`: a bar on a terminal or in a notebook, if it takes more than a second."""
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
    """A function that takes how many more are done; for work whose total is unknown. `None` as in `bar`."""
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
    """A number with its unit, for people; a dash where there is none."""
    return "-" if value is None else f"{value:.{digits}g} {unit}".rstrip()


def unit_of(column: str) -> str:
    """The unit of a column, by the ending of its name.

    Parameters
    ----------
    column : str
        Its name, such as "key_m".

    Returns
    -------
    str
        "1" for a number without.

    Examples
    --------
    >>> from erard import unit_of
    >>> unit_of("hammer_rad_per_s"), unit_of("key_m")
    ('rad/s', 'm')
    """
    return _erard.unit(column)
