"""Calls of the package with bad arguments, drawn by chance from the functions' own signatures.

`python attack.py 1000 1500` makes the calls of the seeds 1000 to 1499 and prints what is wrong with them; `python attack.py --show 1017` prints one.
A function, a method or a parameter that was added today is attacked today: what is not known here how to call properly ends the test.
"""

from __future__ import annotations

import inspect
import os
import random
import re
import signal
import sys
import tempfile
import time
import typing
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import erard
import matplotlib.figure  # noqa: F401 - the package imports it with the first figure; an interrupt would halve that
import numpy as np

#: A call that takes longer is interrupted as by Ctrl-C, and must then end.
PATIENCE_S, TO_END_S = 2.0, 10.0
#: Address space of a call, bytes.
ROOM = 4 << 30
#: Longest message of an error, characters.
MOST_SAID = 20_000

#: What may be raised: the package's own errors, and Python's where something that the function needs is not installed.
ALLOWED = (erard.InputError, erard.SimulationError, ImportError)
#: What Python itself says of a call whose arguments have the wrong names or number. Any other TypeError is a value that
#: nobody has read before it was used.
CALLED_WRONGLY = re.compile(r"unexpected (keyword )?argument|required (positional|keyword)|positional argument|multiple values for")
#: What is raised as well: of a text that has no UTF-8 form, by `Drawing.save` where no file can be written, and where a
#: run, which is a mapping, has no such column.
AS_WELL = {"": UnicodeEncodeError, "Drawing.save": OSError, "Run.plot": KeyError}


def _recording() -> dict[str, Any]:
    time_s = np.arange(0.0, 0.08, 1e-3)
    return {"time_s": time_s, "force_N": 5.0 * (time_s > 0.01), "key_m": 0.01 * np.clip((time_s - 0.01) / 0.03, 0.0, 1.0)}


#: By a parameter's name, what a good call gives where the parameter has no default or a costly one.
GOOD: dict[str, Callable[[], Any]] = {
    "instrument": lambda: GRAND,
    "instruments": lambda: [GRAND],
    "force": lambda: 5.0,
    "forces": lambda: False,
    "duration": lambda: 0.02,
    "recording": _recording,
    "recordings": _recording,
    "source": _recording,
    "text": lambda: GRAND_TEXT,
    "position_m": lambda: 0.0,
    "lift_m": lambda: 0.0,
    "key": lambda: 40,
    "keys": lambda: [40],
    "saved": lambda: erard.Action(GRAND).save(),
    "steps": lambda: 3,
    "restarts": lambda: 0,
    "max_evaluations": lambda: 2,
    "progress": lambda: False,
    "only": lambda: ["dip_mm"],
    "vary": lambda: ["body.hammer.mass"],
    "parameters": lambda: ["body.hammer.mass"],
    "column": lambda: "key_m",
    "time_s": lambda: [0.0, 0.01],
    "value": lambda: 5.0,
    "path": lambda: "out.svg",
    "threads": lambda: 2,
    "design": lambda: "concert-grand",
}
#: The same for one function, before those by name. A function that asks for so much is called with cheaper work.
OWN: dict[str, dict[str, Callable[[], Any]]] = {
    "Action.play": {"force": lambda: [5.0, 5.0, 5.0]},
    "rollout": {"force": lambda: [[5.0, 5.0, 5.0]], "dt": lambda: 1e-3},
    "study": {"axes": lambda: {"let_off": [0.0]}},
    "gradient": {"parameters": lambda: ["let_off"], "compare": lambda: False},
    "Recording.at": {"column": lambda: "key_m"},
    "Recording.noise": {"column": lambda: "key_m"},
    "Keys.restore": {"saved": lambda: KEYS.save(40)},
    "Instrument.kinematics": {"steps": lambda: 5},
    "kinematics": {"steps": lambda: 5},
    "sample": {"of": lambda: FITTED, "fit": lambda: FITTED, "found": lambda: FITTED, "count": lambda: 4},
}
#: Results, which the package makes itself: their constructors are no entrance. Their methods are attacked.
RESULTS: dict[str, Callable[[], Any]] = {
    "Action": lambda: erard.Action(GRAND),
    "Comparison": lambda: GRAND.compare(_recording(), drives=["force"], models=["action"], progress=False),
    "Diagnosis": lambda: erard.diagnose(key="C4", down_weight_g=58, up_weight_g=18),
    "Drawing": lambda: GRAND.draw(),
    "Fit": lambda: FITTED,
    "Gradient": lambda: erard.gradient(GRAND, ["let_off"], force=5.0, duration=0.02, compare=False, progress=False),
    "Instrument": lambda: GRAND,
    "Keyboard": lambda: erard.keyboard(keys=[40], progress=False),
    "Keys": lambda: KEYS,
    "Kinematics": lambda: GRAND.kinematics(steps=5),
    "Posterior": lambda: erard.Posterior(["a"], np.zeros((4, 1)), 0.5),
    "Recording": lambda: erard.Recording(_recording()),
    "Rollout": lambda: erard.rollout(GRAND, force=[[5.0, 5.0]], dt=1e-3, progress=False),
    "Run": lambda: GRAND.press(force=5.0, duration=0.02, progress=False),
    "Sheet": lambda: GRAND.measure(only=["dip_mm"], progress=False),
    "Study": lambda: erard.study(GRAND, let_off=[0.0], force=5.0, duration=0.02, progress=False),
    "Table": lambda: erard.Action(GRAND).play([5.0] * 3),
}
#: Classes whose constructors users call. What is no class of the package's own (named tuples) checks nothing by itself:
#: it is attacked as an argument.
MADE = ("Action", "Instrument", "Keys", "Recording")
#: Methods that a class has from Python's own.
INHERITED = ("get", "items", "keys", "values", "count", "index")

GRAND = erard.load("concert-grand-rigid")
GRAND_TEXT = getattr(GRAND, "text", "")
KEYS = erard.Keys("concert-grand-rigid") if "concert-grand-rigid" in erard.builtin() else erard.Keys()
FITTED = None


def _numbers() -> list[Any]:
    huge = [1e9, -1e9, 1e300, -1e300, 5e-324, 1e-12, 2**40, -(2**63), 10**400]
    return [float("nan"), float("inf"), -float("inf"), -1, -1e-3, 0, 0.0, -0.0, True, 1j, np.float32("nan"), np.int8(-1), *huge]


def _bad(rng: random.Random) -> Any:
    """A bad value of any kind."""
    one = rng.choice(_numbers())
    values = [
        one, one, [one], [[one]], (one, one), [one] * 3, {"let_off": one}, {"x": one}, {"time_s": [0.0, one], "force_N": [one, 1.0]},
        np.array(one, dtype=object), np.array([]), np.zeros((0, 3)), np.zeros((2, 2, 2)), np.full(5, np.nan), np.ma.masked_array([1.0, 2.0], mask=[True, False]),
        np.array(["a"]), np.array([1j]), np.array([1, 2], dtype="datetime64[s]"), None, "", " ", "x", "nan", "-1 mm", "1e999 mm", "\0", "\ud800", "a" * 100_000,
        "../..", "/dev/zero", "/no/such/file", Path("/"), b"", b"\xff" * 10, bytes(5000), [], (), {}, [None], ["let_off", "let_off"], ["let_off", 1],
        object(), Ellipsis, int, lambda *_: 1 / 0, iter([1.0]), erard.Hand(mass_kg=one), erard.Hand(stiffness_n_per_m=one, start_m=one), GRAND, slice(None),
    ]  # fmt: skip
    return rng.choice(values)


def targets() -> dict[str, tuple[Callable[[], Callable[..., Any]], Callable[..., Any]]]:
    """Every function and method of the package: how it is got, and what has its signature."""
    found: dict[str, tuple[Callable[[], Callable[..., Any]], Callable[..., Any]]] = {}
    for name in erard.__all__:
        thing = getattr(erard, name)
        if inspect.ismodule(thing) or name.startswith("_") or not callable(thing):
            continue
        if not inspect.isclass(thing):
            found[name] = (lambda thing=thing: thing, thing)
            continue
        if issubclass(thing, (BaseException, tuple)) or name == "Parameter":
            continue
        if name not in RESULTS:
            raise LookupError(f"erard.{name} is new: say in RESULTS how one is made")
        if name in MADE:
            found[name] = (lambda thing=thing: thing, thing)
        for method, function in inspect.getmembers(thing, inspect.isfunction):
            if not method.startswith("_") and method not in INHERITED:
                found[f"{name}.{method}"] = (lambda name=name, method=method: getattr(RESULTS[name](), method), function)
    # What takes nothing cannot be called badly.
    return {name: one for name, one in found.items() if any(parameters(one[1]))}


def parameters(function: Callable[..., Any]) -> Iterator[tuple[str, inspect.Parameter]]:
    """What a function takes; the keys of a typed dictionary of keywords are parameters, too."""
    for name, one in inspect.signature(function).parameters.items():
        if name == "self":
            continue
        yield name, one
        if one.kind is one.VAR_KEYWORD and "Stepping" in str(one.annotation):
            stepping = typing.get_type_hints(sys.modules["erard._common"].Stepping)
            yield from ((key, inspect.Parameter(key, one.KEYWORD_ONLY, default=None)) for key in stepping)


def call(seed: int) -> tuple[str, Callable[[], Any]]:
    """The call of a seed, in words, and as a function."""
    rng = random.Random(seed)
    all_targets = targets()
    # One after the other: none is left out by chance.
    name = sorted(all_targets)[seed % len(all_targets)]
    get, function = all_targets[name]
    known = dict(parameters(function))
    chosen = rng.sample(sorted(known), min(len(known), rng.choice([1, 1, 1, 2])))
    own = OWN.get(name, {})
    given: list[Any] = []
    named: dict[str, Any] = {}
    for parameter, one in known.items():
        value: Any = inspect.Parameter.empty
        if parameter in chosen:
            value = _bad(rng)
            if one.kind in (one.VAR_POSITIONAL, one.VAR_KEYWORD):
                key = rng.choice(["let_off", "body.hammer.mass", "x", "dip", "columns", "stroke", "duration"])
                (given.append(value) if one.kind is one.VAR_POSITIONAL else named.__setitem__(key, value))
                continue
        elif one.kind in (one.VAR_POSITIONAL, one.VAR_KEYWORD):
            continue
        elif parameter in own:
            value = own[parameter]()
        elif one.default is inspect.Parameter.empty or parameter in ("duration", "progress", "restarts", "max_evaluations", "steps", "only", "keys"):
            if parameter not in GOOD and one.default is inspect.Parameter.empty:
                raise LookupError(f"{name}: say in GOOD or OWN what a good call gives as {parameter}")
            value = GOOD[parameter]() if parameter in GOOD else inspect.Parameter.empty
        elif parameter == "force" and "stroke" not in chosen:
            value = GOOD["force"]()
        if value is inspect.Parameter.empty:
            continue
        if one.kind is one.POSITIONAL_ONLY:
            given.append(value)
        else:
            named[parameter] = value
    shown = ", ".join([*(f"{value!r:.60}" for value in given), *(f"{key}={value!r:.60}" for key, value in named.items())])
    return f"{name}({shown})", lambda: get()(*given, **named)


class TooLong(KeyboardInterrupt):
    """The patience is over."""


def _interrupt(*_: Any) -> None:
    raise TooLong


def wrong(seed: int) -> tuple[str, str | None]:
    """What is wrong with the call of a seed, if anything is; and how it ended: returned, refused or interrupted."""
    told, play = call(seed)
    begun = time.monotonic()
    signal.signal(signal.SIGALRM, _interrupt)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
    end, fault = "returned", None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            play()
    except TooLong:
        end = "interrupted"
    except (*ALLOWED, TypeError, AS_WELL[""], AS_WELL.get(told.partition("(")[0], TypeError)) as error:
        end = "refused"
        if isinstance(error, TypeError) and not CALLED_WRONGLY.search(str(error)):
            fault = f"TypeError: {str(error)[:300]}"
        elif len(str(error)) > MOST_SAID and not isinstance(error, OSError):
            fault = f"a message of {len(str(error))} characters"
        elif not str(error).strip():
            fault = f"{type(error).__name__} without words"
    except BaseException as error:
        end, fault = "raised", f"{type(error).__module__}.{type(error).__name__}: {str(error)[:300]}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    if (took := time.monotonic() - begun) > PATIENCE_S + TO_END_S:
        fault = f"it took {took:.1f} s to end"
    return end, None if fault is None else f"seed {seed}: {told}: {fault}"


def main(arguments: list[str]) -> int:
    global FITTED
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
    with warnings.catch_warnings(), tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("ignore")
        os.chdir(folder)
        FITTED = erard.fit(GRAND, _recording(), parameters=["body.hammer.mass"], sigma={"key_m": 1e-4, "force_N": 0.0}, restarts=0, max_evaluations=2, progress=False)
        if arguments[0] == "--show":
            print(call(int(arguments[1]))[0])
            return 0
        faults, ends = 0, dict.fromkeys(["returned", "refused", "interrupted", "raised"], 0)
        options = [one for one in arguments if one.startswith("--")]
        for seed in range(*(int(one) for one in arguments if one not in options)):
            # Whoever reads this knows at which one the process ended, if it did.
            print(f"at {seed}", flush=True)
            end, fault = wrong(seed)
            ends[end] += 1
            if "--returned" in options and end == "returned":
                print(f"returned: seed {seed}: {call(seed)[0]}", flush=True)
            if fault:
                faults += 1
                print(f"wrong: {fault}", flush=True)
            left = [path.name for path in Path().iterdir()]
            # Only a call that saves writes a file.
            if left and not call(seed)[0].startswith("Drawing.save"):
                faults += 1
                print(f"wrong: seed {seed}: {call(seed)[0]}: left {left}", flush=True)
            for name in left:
                Path(name).unlink()
        print(f"ends: {ends}", flush=True)
        os.chdir("/")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
