"""A chord is heard alike through Python, C and units for simulators."""

import ctypes
import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import erard
import pytest
from test_command import command

NAME, STEP_S, PEDAL_M, FORCE_N = "concert-grand-strings", 1 / 24000, 0.007, 6.0
CHORD = (40, 44, 47)
#: Milliseconds that are listened to: hammers, dampers and strings, for 24 steps each.
HEARD_MS, PERIOD = 120, 24


class Input(ctypes.Structure):
    """`ErardInput` of erard.h."""

    _fields_ = [("kind", ctypes.c_uint32), ("reserved", ctypes.c_uint32), *((name, ctypes.c_double) for name in ("n", "m", "m_per_s", "kg", "n_per_m", "n_s_per_m"))]


class Callbacks(ctypes.Structure):
    """`fmi2CallbackFunctions`: this unit calls none of them but the logger, which is not there."""

    _fields_ = [(name, ctypes.c_void_p) for name in ("logger", "allocate", "free", "finished", "environment")]


def library() -> Path:
    """The library liberard beside the command that `ERARD` names, or where tests build it."""
    folder = Path(command()).resolve().parent
    for place in (folder / "liberard_c.so", folder / "deps" / "liberard_c.so"):
        if place.exists():
            return place
    pytest.skip(f"no liberard_c.so beside {folder / 'erard'}: cargo build --release -p erard-c")


def in_c(path: Path) -> Iterator[list[float]]:
    """Each key's force on the bridge after each millisecond, N, as `erard_keyboard_*` plays it."""
    c = ctypes.CDLL(os.fspath(path))
    c.erard_keyboard_builtin.restype = ctypes.c_void_p
    keyboard = ctypes.c_void_p(c.erard_keyboard_builtin(NAME.encode(), ctypes.c_double(STEP_S), None))
    assert keyboard.value
    assert c.erard_keyboard_set_pedal(keyboard, ctypes.c_double(PEDAL_M)) == 0
    pressed, count, force = Input(kind=1, n=FORCE_N), ctypes.c_size_t(), ctypes.c_double()
    for key in CHORD:
        assert c.erard_keyboard_drive(keyboard, key, ctypes.byref(pressed)) == 0
    for _ in range(HEARD_MS):
        assert c.erard_keyboard_step(keyboard, PERIOD, None, ctypes.c_size_t(0), ctypes.byref(count)) >= 0
        heard = []
        for key in CHORD:
            assert c.erard_keyboard_bridge_force(keyboard, key, ctypes.byref(force)) == 0
            heard.append(force.value)
        yield heard
    c.erard_keyboard_free(keyboard)


def in_a_unit(key: int, begin: bytes, folder: Path) -> Iterator[float]:
    """A key's force on the bridge after each millisecond, N, as a unit made by `erard fmu` plays it from a saved state."""
    import subprocess

    unit = folder / f"{key}.fmu"
    subprocess.run([command(), "fmu", f"{NAME}:key={key}", "--library", library(), "-o", unit], check=True, capture_output=True)
    with zipfile.ZipFile(unit) as archive:
        archive.extractall(folder / str(key))
    root = ElementTree.parse(folder / str(key) / "modelDescription.xml").getroot()
    references = {one.get("name"): ctypes.c_uint32(int(one.get("valueReference", ""))) for one in root.iter("ScalarVariable")}
    fmi = ctypes.CDLL(os.fspath(folder / str(key) / "binaries/linux64/erard.so"))
    fmi.fmi2Instantiate.restype = ctypes.c_void_p
    where = (folder / str(key) / "resources").as_uri().encode()
    guid = str(root.get("guid")).encode()
    own = ctypes.c_void_p(fmi.fmi2Instantiate(b"key", 1, guid, where, ctypes.byref(Callbacks()), 0, 0))
    assert own.value

    def set_real(name: str, value: float) -> None:
        assert fmi.fmi2SetReal(own, ctypes.byref(references[name]), ctypes.c_size_t(1), ctypes.byref(ctypes.c_double(value))) == 0

    assert fmi.fmi2SetupExperiment(own, 0, ctypes.c_double(0.0), ctypes.c_double(0.0), 0, ctypes.c_double(0.0)) == 0
    assert fmi.fmi2EnterInitializationMode(own) == 0
    for name, value in (("step_s", STEP_S), ("force", FORCE_N), ("pedal", PEDAL_M)):
        set_real(name, value)
    assert fmi.fmi2ExitInitializationMode(own) == 0
    state, value = ctypes.c_void_p(), ctypes.c_double()
    assert fmi.fmi2DeSerializeFMUstate(own, begin, ctypes.c_size_t(len(begin)), ctypes.byref(state)) == 0
    assert fmi.fmi2SetFMUstate(own, state) == 0
    # The state is of a key that nothing pressed yet; its clock is the unit's from here on.
    set_real("force", FORCE_N)
    set_real("pedal", PEDAL_M)
    for n in range(HEARD_MS):
        assert fmi.fmi2DoStep(own, ctypes.c_double(n * PERIOD * STEP_S), ctypes.c_double(PERIOD * STEP_S), 0) == 0
        assert fmi.fmi2GetReal(own, ctypes.byref(references["bridge_force"]), ctypes.c_size_t(1), ctypes.byref(value)) == 0
        yield value.value
    fmi.fmi2FreeInstance(own)


def test_a_chord_is_heard_alike(tmp_path: Path) -> None:
    """The force on the bridge of each key of a chord, to the bit, in each millisecond: Python, C, and a unit for each key."""
    path = library()
    keys = erard.Keys(NAME)
    assert keys.step_s == STEP_S
    units = [in_a_unit(key, keys.save(key), tmp_path) for key in CHORD]
    keys.set_pedal(PEDAL_M)
    for key in CHORD:
        keys.drive(key, force=FORCE_N)
    loudest, impacts = 0.0, 0
    for n, heard in enumerate(in_c(path)):
        impacts += len(keys.step(PERIOD))
        own = [keys.reading(key).bridge_n for key in CHORD]
        assert own == heard, n
        assert own == [next(unit) for unit in units], n
        loudest = max(loudest, *map(abs, own))
    assert impacts == 3 and loudest > 1.0
