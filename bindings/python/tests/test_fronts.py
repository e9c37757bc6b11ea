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

    _fields_ = [("struct_size", ctypes.c_uint32), ("kind", ctypes.c_uint32), *((name, ctypes.c_double) for name in ("n", "m", "m_per_s", "kg", "n_per_m", "n_s_per_m"))]


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
    pressed, count, force = Input(struct_size=ctypes.sizeof(Input), kind=1, n=FORCE_N), ctypes.c_size_t(), ctypes.c_double()
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


class Unit:
    """A unit made by `erard fmu`, by the functions of the standard."""

    def __init__(self, name: str, arguments: list[str], folder: Path) -> None:
        import subprocess

        unit, unpacked = folder / f"{name}.fmu", folder / name
        subprocess.run([command(), "fmu", *arguments, "--library", library(), "-o", unit], check=True, capture_output=True)
        with zipfile.ZipFile(unit) as archive:
            archive.extractall(unpacked)
        root = ElementTree.parse(unpacked / "modelDescription.xml").getroot()
        self.references = {one.get("name"): ctypes.c_uint32(int(one.get("valueReference", ""))) for one in root.iter("ScalarVariable")}
        self.fmi = ctypes.CDLL(os.fspath(unpacked / "binaries/linux64/erard.so"))
        self.fmi.fmi2Instantiate.restype = ctypes.c_void_p
        where, guid = (unpacked / "resources").as_uri().encode(), str(root.get("guid")).encode()
        self.own = ctypes.c_void_p(self.fmi.fmi2Instantiate(b"unit", 1, guid, where, ctypes.byref(Callbacks()), 0, 0))
        assert self.own.value

    def begin(self, **values: float) -> None:
        assert self.fmi.fmi2SetupExperiment(self.own, 0, ctypes.c_double(0.0), ctypes.c_double(0.0), 0, ctypes.c_double(0.0)) == 0
        assert self.fmi.fmi2EnterInitializationMode(self.own) == 0
        for name, value in values.items():
            self.set_real(name, value)
        assert self.fmi.fmi2ExitInitializationMode(self.own) == 0

    def set_real(self, name: str, value: float) -> None:
        assert self.fmi.fmi2SetReal(self.own, ctypes.byref(self.references[name]), ctypes.c_size_t(1), ctypes.byref(ctypes.c_double(value))) == 0

    def restore(self, saved: bytes) -> None:
        state = ctypes.c_void_p()
        assert self.fmi.fmi2DeSerializeFMUstate(self.own, saved, ctypes.c_size_t(len(saved)), ctypes.byref(state)) == 0
        assert self.fmi.fmi2SetFMUstate(self.own, state) == 0

    def heard(self, *names: str) -> Iterator[list[float]]:
        """These outputs after each millisecond; the unit is freed at the end."""
        value = ctypes.c_double()
        for n in range(HEARD_MS):
            assert self.fmi.fmi2DoStep(self.own, ctypes.c_double(n * PERIOD * STEP_S), ctypes.c_double(PERIOD * STEP_S), 0) == 0
            found = []
            for name in names:
                assert self.fmi.fmi2GetReal(self.own, ctypes.byref(self.references[name]), ctypes.c_size_t(1), ctypes.byref(value)) == 0
                found.append(value.value)
            yield found
        self.fmi.fmi2FreeInstance(self.own)


def in_a_unit(key: int, begin: bytes, folder: Path) -> Iterator[list[float]]:
    """A key's force on the bridge after each millisecond, N, as the key's own unit plays it from a saved state."""
    unit = Unit(str(key), [f"{NAME}:key={key}"], folder)
    unit.begin(step_s=STEP_S)
    unit.restore(begin)
    # The state is of a key that nothing pressed yet; its clock is the unit's from here on.
    unit.set_real("force", FORCE_N)
    unit.set_real("pedal", PEDAL_M)
    return unit.heard("bridge_force")


def in_a_keyboards_unit(folder: Path) -> Iterator[list[float]]:
    """Each key's force on the bridge after each millisecond, N, and that of all keys, as a keyboard's unit plays them."""
    unit = Unit("keyboard", ["--keyboard", NAME], folder)
    unit.begin(step_s=STEP_S, pedal=PEDAL_M, **{f"key[{key}].force": FORCE_N for key in CHORD})
    return unit.heard(*(f"key[{key}].bridge_force" for key in CHORD), "bridge_force")


def test_a_chord_is_heard_alike(tmp_path: Path) -> None:
    """The force on the bridge of each key of a chord, to the bit, in each millisecond: Python, C, a keyboard's unit, and a unit for each key."""
    path = library()
    keys = erard.Keys(NAME)
    assert keys.step_s == STEP_S
    units = [in_a_unit(key, keys.save(key), tmp_path) for key in CHORD]
    keyboard = in_a_keyboards_unit(tmp_path)
    keys.set_pedal(PEDAL_M)
    for key in CHORD:
        keys.drive(key, force=FORCE_N)
    loudest, impacts = 0.0, 0
    for n, heard in enumerate(in_c(path)):
        impacts += len(keys.step(PERIOD))
        own = [keys.reading(key).bridge_n for key in CHORD]
        assert own == heard, n
        assert own == [next(unit)[0] for unit in units], n
        assert [*own, keys.bridge_n] == next(keyboard), n
        loudest = max(loudest, *map(abs, own))
    assert impacts == 3 and loudest > 1.0
