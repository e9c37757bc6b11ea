"""Instruments: load, vary, press, measure, regulate and draw them."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union, Unpack

import numpy as np

from . import _erard
from ._common import (
    Hand, Stepping, Values, bar, choice, flag, floats, items_of, key_of, mapping, names_of, number, path_of, quantity, refused, step_of, steps, text_of, value_of, whole,
)  # fmt: skip
from ._errors import InputError
from ._recording import Recording, as_recording
from ._run import Run
from ._table import Table

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ._recording import RecordingLike
    from ._types import Change

    Force = Union[float, Sequence[float], NDArray[np.floating[Any]], NDArray[np.integer[Any]]]


@dataclass(frozen=True)
class Parameter:
    """A named parameter of an instrument, which can be varied by its name.

    Attributes
    ----------
    name : str
        Name of a screw, or
        `body.NAME.mass`, `body.NAME.friction`, `spring.NAME.torque`, `zone.NAME.stiffness`, `zone.NAME.damping`,
        `zone.NAME.friction`.
    value : float
        Value in `unit` (SI).
    unit : str
        SI unit; empty for a coefficient.
    is_screw : bool
        Whether it is the setting of a screw.
    range : (float, float)
        Range of values that `Instrument.vary` takes, in `unit`.
    spread : (float, float) or None
        Uncertainty that the file states, as a range of values in `unit`.
    certainty : str or None
        "measured", "read", "second-hand" or "estimate"; `None` for a parameter without a source.
    path : str
        Path of the parameter in the file.
    """

    name: str
    value: float
    unit: str
    is_screw: bool
    range: tuple[float, float]
    spread: tuple[float, float] | None
    certainty: str | None
    path: str


def instrument_of(value: Any, key: str = "instrument") -> Instrument:
    """Returns the instrument, or raises an error that says how to get one."""
    if not isinstance(value, Instrument):
        kind = repr(value) if isinstance(value, str) else type(value).__name__
        raise InputError(f"{key}: found {kind}, expected an Instrument, as erard.load gives it", key=key, found=kind)
    return value


class Instrument:
    """A piano action: bodies, felts, springs and screws. Make one with `erard.load`.

    An instrument never changes: `vary` and `regulate` return new ones. Two instruments are equal if all their
    parameters are. Pickling keeps the file's text and the changes.

    Parameters
    ----------
    text : str
        The text of an instrument file (TOML).
    name : str
        Name of the file in messages.
    changes : sequence of (str, str or float)
        Changes, applied one after the other, as `vary` takes them.

    Examples
    --------
    >>> import erard
    >>> grand = erard.load("concert-grand")
    >>> heavy = grand.vary({"body.hammer.mass": "+0.8 g"}, let_off="-0.2 mm")
    >>> heavy == grand, heavy.changes
    (False, [('body.hammer.mass', '+0.8 g'), ('let_off', '-0.2 mm')])
    """

    __slots__ = ("_inner", "regulation")

    #: Outcome of each goal and screw if `regulate` made the instrument, else `None`.
    regulation: Mapping[str, Any] | None

    def __init__(self, text: str, *, name: str = "text", changes: Sequence[Change] = ()) -> None:
        wanted = "a list of pairs, each a name and a text or a number"
        pairs = items_of("changes", changes, wanted)
        if not all(isinstance(one, tuple) and len(one) == 2 and isinstance(one[0], str) for one in pairs):
            raise refused("changes", changes, wanted)
        made: list[Change] = [(key, value_of(key, value)) for key, value in pairs]
        self._inner = _erard.Instrument(text_of("text", text, "the text of an instrument file"), text_of("name", name), made)
        self.regulation = None

    @classmethod
    def _of(cls, inner: _erard.Instrument) -> Instrument:
        made = cls.__new__(cls)
        made._inner, made.regulation = inner, None
        return made

    @property
    def name(self) -> str:
        """Name of the instrument, e.g. "Concert grand, C4"."""
        return self._inner.name

    @property
    def key(self) -> int | None:
        """Number of the piano's key that the instrument is, 1 (A0) to 88 (C8); None if it is not known."""
        return self._inner.key

    @property
    def sample(self) -> int | None:
        """Number of the random sample that the instrument's file was drawn as; None for other files."""
        return self._inner.sample

    @property
    def description(self) -> str:
        """Description of the instrument from its file."""
        return self._inner.description

    @property
    def text(self) -> str:
        """Text of the file that the instrument was read from, without the changes."""
        return self._inner.text

    @property
    def changes(self) -> list[Change]:
        """Changes to the file, in the order in which they were made."""
        return self._inner.changes

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies."""
        return self._inner.bodies

    @property
    def zones(self) -> list[str]:
        """Names of the contact zones."""
        return self._inner.zones

    @property
    def screws(self) -> dict[str, str]:
        """Screws by name, with the effect of a positive turn."""
        return dict(self._inner.screws)

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All named parameters, by their names."""
        rows = (Parameter(**_tuples(row)) for row in self._inner.quantities())
        return {row.name: row for row in rows}

    def vary(self, changes: Mapping[str, float | str] | None = None, /, **more: float | str) -> Instrument:
        """Returns a copy of the instrument with some parameters changed.

        Parameters
        ----------
        changes, **more : mapping of str to str or float
            Changes by name: a screw or a parameter (see `parameters`), or any number of the file by its path, as in
            "body.hammer.mass_g" or "zone.string.disc.center_mm.x".

            A text is a new value ("8.7 g"), an amount to add with its sign ("+0.8 g", "-0.2 mm"), or a factor ("x1.5",
            "*1.5"). A new value that has a sign needs an equals sign ("=-0.2 mm").

            A number, or a text without a unit, is in SI units: a screw's setting in m, rad or N m, a mass in kg. A
            number of the file is in the unit at the end of its path. It is never a factor.

        Returns
        -------
        Instrument

        Raises
        ------
        InputError
            If a name or a value is wrong; the error holds the key, what was found and what is expected.

        Examples
        --------
        >>> import erard
        >>> grand = erard.load("concert-grand")
        >>> mass = grand.parameters["body.hammer.mass"].value
        >>> heavy = grand.vary({"body.hammer.mass": "+1 g"})
        >>> round(1e3 * (heavy.parameters["body.hammer.mass"].value - mass), 6)
        1.0
        >>> grand.vary(let_of="1 mm")
        Traceback (most recent call last):
        erard._errors.InputError: unknown name `let_of`; ...nearest `let_off`...
        """
        asked: list[Change] = []
        for key, value in {**mapping("changes", changes), **more}.items():
            asked.append((str(key), value_of(str(key), value)))
        return Instrument._of(self._inner.varied(asked))

    def press(
        self,
        force: Force | None = None,
        *,
        dt: float | None = None,
        stroke: str | RecordingLike | None = None,
        touch: str = "pressed",
        motion: ArrayLike | None = None,
        rigid: ArrayLike | None = None,
        drive: str | None = None,
        hammer_speed: float | None = None,
        model: str = "action",
        duration: float | None = None,
        record_every: int | None = None,
        tolerance: float | None = None,
        reactions: bool = False,
        losses: bool = False,
        progress: bool | None = None,
        **how: Unpack[Stepping],
    ) -> Run:
        """Presses the key once, from rest.

        Parameters
        ----------
        force : float or array_like of shape (T,), optional
            Force of the finger, N, pushing positive: constant, or one sample every `dt` s.
        dt : float, optional
            Time between samples of `force`, `motion` or `rigid`, s.
        stroke : {"pp", "p", "mf", "f", "ff"}, path or recording, optional
            A built-in touch (default "mf"), played by a hand whose force is adjusted so that this action reaches the
            level; or a recording: a run, a mapping of arrays with `time_s`, a data frame, or a file. Whatever holds its
            numbers, it is prepared as the command does it (zero of the rest, low-pass of noise); `Run.notes` says how.
            A `Recording` is prepared as it says.
        touch : {"pressed", "struck"}
            Touch of a built-in stroke: the finger starts on the key, or strikes it.
        hammer_speed : float, optional
            Level of a built-in touch: total hammer speed at the string, m/s. "pp" to "ff" are 0.5, 0.79, 1.99, 3.15 and
            5.
        motion : array_like of shape (T,), optional
            Position of the fingertip, m down from the key's rest. The finger is soft and can only push.
        rigid : array_like of shape (T,), optional
            Prescribed position of the key front itself, m down from rest.
        drive : {"force", "motion", "rigid"}, optional
            Quantity of a recording that drives the key; by default its force if there is one. With "pp" to "ff",
            `drive` plays the force curve of that name. With "motion", the fingertip's motion is computed from key and
            force. If the recording begins with a force, the fingertip has already pressed the key down before the run
            starts; `Run.notes` then says so.
        model : {"action", "one-dof"}
            The whole action, or its model with one degree of freedom.
        duration : float, optional
            Simulated time, s; by default a little longer than the stroke.
        record_every : int, optional
            Number of steps from one recorded row to the next.
        tolerance : float, optional
            Tolerance for adaptive steps, 1e-9 to 0.1: each step is as long as its error allows.
        reactions : bool
            Also record accelerations and pin forces: columns `NAME_rad_per_s2`, `NAME_pin_x_N` (force of the pin on the
            body toward the back of the piano) and `NAME_pin_y_N` (upward).
        losses : bool
            Also record the energy losses by pin and by contact: `Run.losses`.
        progress : bool, optional
            Whether to show a progress bar; by default on a terminal or in a notebook, after one second.
        **how
            How to step: `step` (s), `theta`, `solver`, `friction`, `friction_width`.

        Returns
        -------
        Run

        Examples
        --------
        >>> import erard
        >>> grand = erard.load("concert-grand")
        >>> loud, soft = grand.press(force=10.0), grand.press(force=3.0)
        >>> loud.hammer_speed > soft.hammer_speed
        True
        >>> grand.press(stroke="mf", touch="struck").title
        'mf, struck'
        """
        made = stroke_of(
            self, force=force, dt=dt, stroke=stroke, touch=touch, motion=motion, rigid=rigid, drive=drive,
            hammer_speed=hammer_speed, hand=how.get("hand"),
        )  # fmt: skip
        duration = None if duration is None else number("duration", duration)
        every = None if record_every is None else whole("record_every", record_every)
        accuracy = None if tolerance is None else number("tolerance", tolerance)
        choice("model", model, MODELS)
        reactions, losses = flag("reactions", reactions), flag("losses", losses)
        with bar(progress, "press") as tell:
            columns, about = _erard.press(
                self._inner, made, steps(how), model, duration, every, accuracy, reactions, losses, tell
            )
        return Run(columns, {**about, "notes": made.notes, "preparation": preparation_of(made)}, made.title)

    def measure(
        self,
        *,
        key: int | str | None = None,
        only: Sequence[str] | None = None,
        rest: str = "as-played",
        progress: bool | None = None,
    ) -> Sheet:
        """Measures the action as a technician does: weights, distances, inertia, repetition, timing.

        Parameters
        ----------
        key : int or str, optional
            Key of the piano whose norms the values are compared with, by number (1 to 88) or note ("A0" to "C8"). By
            default the instrument's own, or middle C if it does not know its key; another key than its own is an
            error.
        only : sequence of str, optional
            Names of the lines to measure, such as "down_weight_g", "effective_inertia_kg", "let_off_mm"; by default
            all.
        rest : {"as-played", "as-drawn"}
            How the action comes to rest before it is measured: played once and released, which is what a technician
            reads, or settled from the angles in the file, where `press` starts.
        progress : bool, optional
            A progress bar.

        Returns
        -------
        Sheet
            Mapping with the keys of measure.json, which `erard measure` writes.

        Examples
        --------
        >>> import erard
        >>> sheet = erard.load("concert-grand").measure(only=["let_off_mm", "dip_mm"])
        >>> sorted(sheet)
        ['dip_mm', 'let_off_mm']
        """
        of = None if key is None else key_of("key", key)
        lines = None if only is None else names_of("only", only)
        choice("rest", rest, RESTS)
        with bar(progress, "measure") as tell:
            found, judged = _erard.measure(self._inner, of, lines, rest, tell)
        return Sheet(self.name, json.loads(found), judged)

    def regulate(
        self,
        *,
        norms: bool = False,
        follow: bool = False,
        rest: str = "as-played",
        progress: bool | None = None,
        **goals: float | str,
    ) -> Instrument:
        """Turns the screws until the goals are met, as a technician does, and returns the regulated instrument.

        Parameters
        ----------
        norms : bool
            Use the trade's norms for goals that are not given. Without any goal and without norms, what is out of its
            usual range is set to the norm, and all else stays as it is.
        follow : bool
            Also turn other screws to restore the distances that the goals disturb.
        rest : {"as-played", "as-drawn"}
            How the action comes to rest before it is measured: played once and released, which is what a technician
            reads, or settled from the angles in the file, where `press` starts.
        progress : bool, optional
            A progress bar.
        **goals
            `dip`, `blow`, `let_off`, `drop`, `check`, `repetition_rise`, `repetition_spring`, `jack_position`,
            `lever_height`, `damper_start`: a text with a unit ("1.5 mm", "300 mm/s", "50 %") or a number in SI units
            (m, m/s, share).

        Returns
        -------
        Instrument
            The regulated instrument. Its `regulation` holds `goals`, `screws` and `all_met`; a goal that cannot be met
            is approached as closely as possible.

        Examples
        --------
        >>> import erard
        >>> regulated = erard.load("concert-grand").regulate(let_off="2 mm")
        >>> regulated.regulation["all_met"], [screw["screw"] for screw in regulated.regulation["screws"]]
        (True, ['let_off'])
        """
        asked: list[Change] = [(name, value_of(name, goal)) for name, goal in goals.items()]
        norms, follow = flag("norms", norms), flag("follow", follow)
        choice("rest", rest, RESTS)
        with bar(progress, "regulate") as tell:
            inner, about = _erard.regulate(self._inner, asked, norms, follow, rest, tell)
        made = Instrument._of(inner)
        made.regulation = about
        return made

    def kinematics(self, *, start: float = 0.0, end: float | None = None, steps: int = 200) -> Kinematics:
        """Computes leverage and sliding over the key's travel, from the geometry alone; see `erard.kinematics`.

        Parameters
        ----------
        start, end : float
            Key travel at the beginning and at the end, m; by default from rest to let-off.
        steps : int
            Number of steps between the two.

        Returns
        -------
        Kinematics
        """
        return kinematics(self, start=start, end=end, steps=steps)

    def compare(
        self,
        recording: RecordingLike,
        *,
        drives: Sequence[str] | None = None,
        models: Sequence[str] | None = None,
        duration: float | None = None,
        progress: bool | None = None,
        **how: Unpack[Stepping],
    ) -> Comparison:
        """Plays a recording on the models and compares the results with the recorded columns.

        Parameters
        ----------
        recording : run, mapping, data frame, path or Recording
            The recording.
        drives : sequence of {"force", "motion", "rigid"}, optional
            Drives to try; by default all those that the recording allows.
        models : sequence of {"action", "one-dof"}, optional
            Models to play; by default both.
        duration : float, optional
            Compared duration, s; by default the whole recording.
        progress, **how
            As in `press`.

        Returns
        -------
        Comparison

        Examples
        --------
        >>> import erard
        >>> grand = erard.load("concert-grand")
        >>> own = grand.compare(grand.press(force=5.0, duration=0.2), drives=["force"], models=["action"])
        >>> own.errors[0]["explained"] > 0.9999
        True
        """
        made = as_recording(recording)
        driven = None if drives is None else [choice("drives", name, DRIVES) for name in names_of("drives", drives)]
        played = None if models is None else [choice("models", name, MODELS) for name in names_of("models", models)]
        with bar(progress, "compare") as tell:
            found = _erard.compare(
                self._inner,
                made._inner,
                driven,
                played,
                None if duration is None else number("duration", duration),
                steps(how),
                tell,
            )
        return Comparison(*found, made.notes)

    def validate(self, *, progress: bool | None = None) -> list[dict[str, Any]]:
        """Compares the instrument with measurements on real pianos.

        Parameters
        ----------
        progress : bool, optional
            A progress bar.

        Returns
        -------
        list of dict
            A row for each published number: `name`, `quantity`, `group`, `kind` ("set" or "predicted"), `unit`,
            `published`, `at_least`, `at_most`, `simulated`, `verdict` ("met", "missed", "did not happen",
            "not modelled", "nothing published"), `missed_by`, `source`, `certainty`, `likely_reason`.
        """
        with bar(progress, "validate") as tell:
            return _erard.validate(self._inner, tell)

    def draw(
        self,
        at: float | str = 0.0,
        *,
        force: Force | None = None,
        dt: float | None = None,
        stroke: str | RecordingLike | None = None,
        touch: str = "pressed",
        labels: bool = False,
        forces: bool = False,
        **how: Unpack[Stepping],
    ) -> Drawing:
        """Draws the action in one pose of a stroke.

        Parameters
        ----------
        at : float or str
            Time after the stroke's start, s, 0 to 600 (0 is rest); or an event: "key_start", "toe_contact", "let_off",
            "hammer_contact", "key_bottom", "check".
        force, dt, stroke, touch, **how
            As in `press`.
        labels : bool
            Whether to name the main parts.
        forces : bool
            Whether to show contact forces as arrows.

        Returns
        -------
        Drawing
            The drawing; a notebook shows it, `save` writes the SVG.

        Examples
        --------
        >>> import erard
        >>> drawing = erard.load("concert-grand").draw("let_off", stroke="mf", labels=True)
        >>> drawing.svg.startswith("<svg")
        True
        """
        labels, forces = flag("labels", labels), flag("forces", forces)
        made = stroke_of(self, force=force, dt=dt, stroke=stroke, touch=touch, hand=how.get("hand"))
        own = steps(how)
        if isinstance(at, str):
            happened = self.press(force, dt=dt, stroke=stroke, touch=touch, **how).events
            known = ["key_start", "toe_contact", "let_off", "hammer_contact", "key_bottom", "check"]
            name = at.replace("-", "_")
            if name not in known:
                raise InputError(f"at: found {at!r}, expected seconds or one of {', '.join(known)}", key="at", found=at)
            if name not in happened:
                raise InputError(f"at: there is no {name.replace('_', ' ')} in this stroke", key="at", found=at)
            step = step_of(own, self._inner.usual_step_s)
            at_s = math.ceil((happened[name] - made.start_s) / step) * step
            what = f", {name.replace('_', ' ')}"
        else:
            at_s, what = number("at", at), ""
            if not 0 <= at_s <= 600:
                raise InputError(f"at: found {at_s} s, expected 0 to 600 s", key="at", found=str(at_s))
        caption = f"{self.name}, at rest" if at_s == 0 else f"{self.name}, {made.title}, {1e3 * at_s:.1f} ms{what}"
        return Drawing(_erard.draw(self._inner, made, at_s, own, labels, forces, caption))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Instrument):
            return NotImplemented
        return self._inner.equals(other._inner)

    def __hash__(self) -> int:
        return hash((self.name, tuple(parameter.value for parameter in self.parameters.values())))

    def __repr__(self) -> str:
        told = "".join(f", {key} {change}" for key, change in self.changes)
        return f"<erard.Instrument {self.name}{told}: {len(self.bodies)} bodies, {len(self.zones)} contacts>"

    def _repr_html_(self) -> str:
        caption = html.escape(repr(self).strip("<>"))
        return f'<div style="max-width: 900px">{self.draw().svg}<p>{caption}</p></div>'

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self.text, self._inner.file_name, self.changes, self.regulation)


def _unpickled(text: str, name: str, changes: list[Change], regulation: Mapping[str, Any] | None) -> Instrument:
    made = Instrument(text, name=name, changes=changes)
    made.regulation = regulation
    return made


def _tuples(row: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}


def load(asked: str | os.PathLike[str]) -> Instrument:
    """Loads an instrument.

    Parameters
    ----------
    asked : str or path
        Name of a built-in instrument ("concert-grand"; see `erard.builtin`), a TOML file, or a key of a keyboard
        ("concert-grand:key=40", "mine.toml:key=1").

    Returns
    -------
    Instrument

    Raises
    ------
    InputError
        If the file is wrong; the error holds file, line and key. If there is no such file, `MissingFileError`, which is
        also a `FileNotFoundError`.

    Examples
    --------
    >>> import erard
    >>> erard.load("concert-grand:key=40").name
    'Concert grand, key 40 (C4)'
    >>> erard.load("no-such-file.toml")
    Traceback (most recent call last):
    erard._errors.MissingFileError: no-such-file.toml: cannot be read: ...
    """
    return Instrument._of(_erard.Instrument.load(path_of("asked", asked, "the name of an instrument or the path of its file")))


def preparation_of(stroke: _erard.Stroke) -> list[dict[str, Any]]:
    """Returns what was done to the channels of the recording that a stroke plays; empty if it plays none."""
    found: list[dict[str, Any]] = [] if stroke.preparation is None else json.loads(stroke.preparation)
    return found


def stroke_of(
    on: Instrument,
    *,
    force: Force | None = None,
    dt: float | None = None,
    stroke: str | RecordingLike | None = None,
    touch: str = "pressed",
    motion: ArrayLike | None = None,
    rigid: ArrayLike | None = None,
    drive: str | None = None,
    hammer_speed: float | None = None,
    hand: Hand | None = None,
) -> _erard.Stroke:
    """Returns the stroke that the arguments of `press` describe; a touch is adjusted to the instrument."""
    given = {"force": force, "motion": motion, "rigid": rigid, "stroke": stroke, "hammer_speed": hammer_speed}
    named = [name for name, value in given.items() if value is not None]
    choice("touch", touch, TOUCHES)
    drive = None if drive is None else choice("drive", drive, DRIVES)
    if len(named) > 1:
        raise InputError(f"{' and '.join(named)} are given; expected one of {', '.join(given)}", key=named[1])
    if stroke is not None or hammer_speed is not None or not named:
        if isinstance(stroke, str) and stroke in NUANCES or stroke is None:
            if drive is not None:
                _only_of("hammer_speed", hammer_speed, None, "a hand, which drive= replaces by a force curve")
                return _erard.Stroke.curve(stroke or "mf", touch, drive)
            hand = hand or Hand()
            if hand.start_m or hand.start_m_per_s:
                told = "hand: a touch finds where its hand starts; expected start_m and start_m_per_s of 0"
                raise InputError(told, key="hand", found=repr(hand))
            speed = None if hammer_speed is None else number("hammer_speed", hammer_speed)
            name = f"{speed:g} m/s" if speed is not None else stroke or "mf"
            return _erard.Stroke.level(on._inner, name, speed, touch, hand.mass_kg, hand.joints_m_per_n, hand.joints_s)
        _only_of("touch", touch, "pressed", "a built-in stroke")
        if isinstance(stroke, str) and not os.path.exists(stroke) and not os.path.splitext(stroke)[1] and os.path.basename(stroke) == stroke:
            told = f"stroke: found {stroke!r}, expected {', '.join(NUANCES)} or a recording; there is no such file either"
            raise InputError(told, key="stroke", found=stroke)
        made = as_recording(stroke)
        return _erard.Stroke.recorded(made._inner, drive)
    _only_of("touch", touch, "pressed", "a built-in stroke")
    _only_of("drive", drive, None, "a built-in stroke or a recording")
    name, value = named[0], given[named[0]]
    if name == "force" and (isinstance(value, str) or not hasattr(value, "__len__") or np.ndim(value) == 0):  # type: ignore[arg-type]
        return _erard.Stroke.constant(number("force", value))
    values = floats(name, value, 1)  # type: ignore[arg-type]
    if dt is None:
        raise InputError(f"{name} is an array: expected dt, the time from sample to sample in s", key="dt")
    return _erard.Stroke.samples(name, values, number("dt", dt))


#: Names of the built-in strokes, of touches, drives and models, and how an action comes to rest before it is measured.
NUANCES = ("pp", "p", "mf", "f", "ff")
TOUCHES = ("pressed", "struck")
DRIVES = ("force", "motion", "rigid")
MODELS = ("action", "one-dof")
RESTS = ("as-played", "as-drawn")


def _only_of(key: str, found: Any, usual: str | None, what: str) -> None:
    """Raises an error if an argument would have no effect."""
    if found != usual:
        raise InputError(f"{key}: {found!r} goes with {what} only", key=key, found=found)


class Sheet(Values):
    """Measured values of an action: a mapping with the keys of measure.json, shown as the technician's table."""

    def __init__(self, instrument: str, values: dict[str, Any], key: int = 40) -> None:
        self.instrument, self._values, self._key = instrument, values, key

    def lines(self) -> list[tuple[str, str, str]]:
        """Returns the lines of the table.

        Returns
        -------
        list of (str, str, str)
            Quantity, value with its unit, and usual range at the key of the piano.
        """
        found = []
        whole = "flags" in self._values
        for key, label, unit, decimals, usual, on_request in _erard.measure_lines(self._key):
            if on_request and whole:
                continue
            value: Any = self._values
            for part in key.split("."):
                value = value.get(part) if isinstance(value, Mapping) else None
            if value is None and key not in self._values:
                continue
            told = "-" if value is None else f"{value:.{decimals}f} {unit}".rstrip()
            found.append((label, told, usual))
        return found

    def __repr__(self) -> str:
        rows = "\n".join(f"  {what:<40}{value:>14}   {usual}" for what, value, usual in self.lines())
        return f"{self.instrument}\n{rows}"

    def _repr_html_(self) -> str:
        cells = (f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in self.lines())
        head = "<tr><th></th><th>measured</th><th>usual</th></tr>"
        return f"<table><caption>{html.escape(self.instrument)}</caption>{head}{''.join(cells)}</table>"


class Drawing:
    """Drawing as SVG text in `svg`; a notebook shows it."""

    def __init__(self, svg: str) -> None:
        self.svg = svg

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the SVG to a file.

        Parameters
        ----------
        path : str or path
        """
        Path(path_of("path", path)).write_text(self.svg, encoding="utf-8")

    def _repr_svg_(self) -> str:
        return self.svg

    def __eq__(self, other: object) -> bool:
        return self.svg == other.svg if isinstance(other, Drawing) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.svg)

    def __repr__(self) -> str:
        return f"<erard.Drawing, {len(self.svg)} bytes of SVG>"


class Kinematics(Table):
    """Leverage and sliding over the key's travel. Columns: `key_m`, `leverage`, and `capstan_m` and `knuckle_m`, the
    position of each contact along its lever. `summary` holds the leverage at rest, half-way and at let-off, and the
    distances that the contacts slide."""

    def __init__(self, columns: dict[str, Any], summary: dict[str, Any]) -> None:
        super().__init__(columns)
        self.summary: dict[str, Any] = summary

    def __repr__(self) -> str:
        rest, off = self.summary["leverage_at_rest"], self.summary["leverage_at_let_off"]
        return f"<erard.Kinematics {self.summary['name']}: leverage {quantity(rest, '')} at rest, {quantity(off, '')} at let-off>"


def kinematics(
    design: Instrument | str, *, start: float = 0.0, end: float | None = None, steps: int = 200
) -> Kinematics:
    """Computes leverage and sliding over the key's travel, from the geometry alone.

    Parameters
    ----------
    design : Instrument or str
        An instrument, or a linkage of three levers given by their lengths: a TOML file of kind `three-lever` or a
        built-in linkage ("c7f-like").
    start, end : float
        Key travel at the beginning and at the end, m; by default from rest to let-off.
    steps : int
        Number of steps between the two.

    Returns
    -------
    Kinematics

    Examples
    --------
    >>> import erard
    >>> moved = erard.kinematics("c7f-like")
    >>> 4 < moved.summary["leverage_at_rest"] < 7
    True
    """
    instrument = design._inner if isinstance(design, Instrument) else None
    linkage = None if isinstance(design, Instrument) else path_of("design", design, "an Instrument, or the name or file of a linkage")
    until = None if end is None else number("end", end)
    columns, about = _erard.kinematics(instrument, linkage, number("start", start), until, whole("steps", steps))
    return Kinematics(columns, about)


class Comparison(Table):
    """Comparison of a recording with the models: columns, `errors` (one row for each drive and model), and `verdicts`
    in words; `notes` say how the recording was prepared."""

    def __init__(self, columns: dict[str, Any], errors: list[dict[str, Any]], verdicts: list[str], notes: list[str]) -> None:
        super().__init__(columns)
        self.errors, self.verdicts, self.notes = errors, verdicts, notes

    def __repr__(self) -> str:
        return "\n".join(["<erard.Comparison>", *self.verdicts])


class Keyboard(Table):
    """Weights of the keys of a keyboard, one row for each key."""

    def __init__(self, name: str, columns: dict[str, Any]) -> None:
        super().__init__(columns)
        self.name = name

    def __repr__(self) -> str:
        return f"<erard.Keyboard {self.name}: {len(self['key'])} keys weighed>"


def keyboard(
    asked: str | os.PathLike[str] = "concert-grand",
    *,
    keys: Sequence[int | str] | None = None,
    progress: bool | None = None,
) -> Keyboard:
    """Weighs the keys of a keyboard from bass to treble.

    Parameters
    ----------
    asked : str or path
        The keyboard: a TOML file or a built-in keyboard. A single key is an instrument:
        `erard.load("concert-grand:key=40")`.
    keys : sequence of int or str, optional
        Keys to weigh, by number (1 to 88) or note ("A0" to "C8"); by default every third and the last.
    progress : bool, optional
        A progress bar.

    Returns
    -------
    Keyboard
        Columns `key`, `note`, hammer mass, strike, front, down-, up-, balance and friction weight in g, the hammer
        speed of a mezzo forte, m/s, `trusted`, and `error`: why numbers of this key are nan, else empty.

    Examples
    --------
    >>> import erard
    >>> two = erard.keyboard(keys=[1, 88])
    >>> bool(two["hammer_mass_g"][0] > two["hammer_mass_g"][1]), two["note"].tolist()
    (True, ['A0', 'C8'])
    """
    wanted = "a list of keys, by number from 1 or by note"
    chosen = [*range(1, 88, 3), 88] if keys is None else [key_of("keys", key) for key in items_of("keys", keys, wanted)]
    piano = path_of("asked", asked, "the name of a keyboard or the path of its file")
    with bar(progress, "keyboard") as tell:
        name, columns = _erard.keyboard(piano, chosen, tell)
    return Keyboard(name, {key: np.asarray(values) for key, values in columns.items()})


def builtin() -> dict[str, list[str]]:
    """Returns the names of everything built in.

    Returns
    -------
    dict of str to list of str
        `instruments`, `keyboards`, `linkages`, `strokes`.

    Examples
    --------
    >>> import erard
    >>> erard.builtin()["strokes"]
    ['pp', 'p', 'mf', 'f', 'ff']
    """
    return dict(zip(("instruments", "keyboards", "linkages", "strokes"), _erard.builtin(), strict=True))
