"""fmi.py UNIT MASS SPEED TIME SPEED TIME STRUNG CHORD: validates an unpacked unit with fmpy and plays it; the impact of 5 N as it is, and with a hammer of that mass in g
and the let-off button half a millimetre lower. STRUNG is a unit whose strings sound, with heard.txt: their force on the bridge under a hand, a line each ms. CHORD is a keyboard, with heard.txt: force on the bridge and travel of key 44. UNIT/mass.txt: a hammer's mass, kg, with its inertia, and its blow."""

import ctypes
import sys

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_model_description

unit = sys.argv[1]
mass_g, *expected = [float(x) for x in sys.argv[2:7]]
description = read_model_description(unit, validate=True, validate_variable_names=True, validate_model_structure=True)
problems = validate_model_description(description)
assert not problems, problems
print(f"fmpy: {len(description.modelVariables)} variables, no problems")


def same(found, wanted):
    assert abs(found / wanted - 1) < 1e-12, (found, wanted)


def impact(step, **more):
    outputs = ["hammer_speed", "impact_time", "impact_count", "key", "string_force", "contact.string"]
    result = simulate_fmu(unit, stop_time=0.3, step_size=step, output_interval=step, fmi_type="CoSimulation",
                          output=outputs, start_values={"force": 5.0, **more})
    last = result[-1]
    print(f"communication step {step * 1e6:.0f} us {more or ''}: {last['impact_count']} impacts, {last['hammer_speed']!r} m/s at {last['impact_time']!r} s")
    assert last["impact_count"] == 1
    return last["hammer_speed"], last["impact_time"]


for step in (50e-6, 1e-3, 0.7e-3):
    for found, wanted in zip(impact(step), expected[:2]):
        same(found, wanted)
for step in (50e-6, 1e-3):
    found = impact(step, **{"body.hammer.mass_g": mass_g, "screw.let_off.setting_mm": -0.5})
    for one, wanted in zip(found, expected[2:]):
        same(one, wanted)

# The hammer's mass with its inertia, by one parameter: to the bit.
mass_kg, *whole = [float(x) for x in open(f"{unit}/mass.txt").read().split()]
for step in (50e-6, 1e-3):
    found = impact(step, **{"body.hammer.mass": mass_kg})
    assert list(found) == whole, (found, whole)

# Call by call: states are saved, serialised, brought back; what is wrong is refused, with words.
said = []
references = {v.name: v.valueReference for v in description.modelVariables}
arguments = dict(guid=description.guid, unzipDirectory=unit, modelIdentifier="erard", instanceName="key")


def instance():
    fmu = FMU2Slave(**arguments)
    fmu.instantiate()
    return fmu


def begun(**parameters):
    fmu = instance()
    fmu.setupExperiment(startTime=2.0)
    fmu.enterInitializationMode()
    for name, value in parameters.items():
        fmu.setReal([references[name]], [value])
    fmu.exitInitializationMode()
    return fmu


def get(fmu, name):
    return fmu.getReal([references[name]])[0]


fmu = begun()
fmu.setReal([references["force"]], [5.0])
for n in range(60):
    fmu.doStep(2.0 + n * 1e-3, 1e-3)
state = fmu.getFMUState()
data = fmu.serializeFMUState(state)
ends = []
for turn in range(3):
    for n in range(60, 200):
        fmu.doStep(2.0 + n * 1e-3, 1e-3)
    ends.append([get(fmu, name) for name in ("key", "hammer", "hammer_velocity", "impact_time", "hammer_speed", "contact.string")])
    if turn == 0:
        fmu.setFMUState(state)
        fmu.freeFMUState(state)
    else:
        state = fmu.deSerializeFMUstate(data)
        fmu.setFMUState(state)
        fmu.freeFMUState(state)
assert ends[0] == ends[1] == ends[2], ends
print(f"states: {len(data)} bytes, the same end three times; the impact at {ends[0][3]:.6f} s on the simulator's clock")
assert abs(ends[0][3] - 2.0 - expected[1]) < 1e-9


def refused(what, call):
    try:
        call()
    except Exception as error:
        print(f"refused: {what}: {error}")
        return
    raise AssertionError(f"{what} was taken")


refused("a parameter after initialisation", lambda: fmu.setReal([references["body.hammer.mass_g"]], [1.0]))
refused("an output", lambda: fmu.setReal([references["key"]], [1.0]))
refused("not a number", lambda: fmu.setReal([references["force"]], [float("nan")]))
refused("no such variable", lambda: fmu.getReal([77]))
refused("time that goes back", lambda: fmu.doStep(-5.0, 1e-3))
refused("a mass below zero", lambda: begun(**{"body.hammer.mass_g": -1.0}))
refused("a mass of nothing", lambda: begun(**{"body.hammer.mass": 0.0}))
refused("two masses of one body", lambda: begun(**{"body.hammer.mass": mass_kg, "body.hammer.mass_g": mass_g}))
refused("an absurd force", lambda: (fmu.setReal([references["force"]], [1e30]), fmu.doStep(2.2, 1e-3)))
fmu.setReal([references["force"]], [0.0])
fmu.doStep(2.2, 1e-3)
fmu.reset()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
assert get(fmu, "hammer_speed") == 0.0 and abs(get(fmu, "key")) < 1e-9
fmu.terminate()
fmu.freeInstance()

wrong = FMU2Slave(**{**arguments, "guid": "{0}"})
refused("another guid", wrong.instantiate)

# By motion: the key follows the finger.
fmu = instance()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.setInteger([references["drive"]], [2])
fmu.exitInitializationMode()
for n in range(40):
    fmu.setReal([references["position"], references["velocity"]], [n * 1e-3 * 0.1, 0.1])
    fmu.doStep(n * 1e-3, 1e-3)
assert 3e-3 < get(fmu, "key") < 4.2e-3, get(fmu, "key")
assert get(fmu, "finger_force") > 0.1
fmu.terminate()
fmu.freeInstance()

# The key's own motion: it is where it is put.
fmu = instance()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.setInteger([references["drive"]], [3])
fmu.exitInitializationMode()
for n in range(40):
    fmu.setReal([references["position"], references["velocity"]], [n * 1e-3 * 0.1, 0.1])
    fmu.doStep(n * 1e-3, 1e-3)
assert abs(get(fmu, "key") - 4e-3) < 1e-9, get(fmu, "key")
fmu.terminate()
fmu.freeInstance()

# A hand and the pedal on strings that sound: to the bit what the native action does.
strung = sys.argv[7]
description = read_model_description(strung, validate=True)
references = {v.name: v.valueReference for v in description.modelVariables}
arguments = dict(guid=description.guid, unzipDirectory=strung, modelIdentifier="erard", instanceName="strung")
heard = [float(line) for line in open(f"{strung}/heard.txt")]
fmu = instance()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.setInteger([references["drive"]], [4])
for name, value in {"hand_mass": 0.3, "muscle_damping": 2.0, "force": 7.0, "pedal": 0.007}.items():
    fmu.setReal([references[name]], [value])
fmu.exitInitializationMode()
for n, wanted in enumerate(heard):
    fmu.doStep(n * 1e-3, 1e-3)
    assert get(fmu, "bridge_force") == wanted, (n, get(fmu, "bridge_force"), wanted)
assert get(fmu, "hand") > 5e-3 and max(map(abs, heard)) > 1.0
print(f"strings: {len(heard)} forces on the bridge, the same bits; the hand is {1e3 * get(fmu, 'hand'):.1f} mm down")
fmu.terminate()
fmu.freeInstance()

# A keyboard: a chord by the keys' own inputs, to the bit what the native keys do; an input that moves is taken as a
# signal.
chord = sys.argv[8]
description = read_model_description(chord, validate=True, validate_variable_names=True, validate_model_structure=True)
problems = validate_model_description(description)
assert not problems, problems
assert description.variableNamingConvention == "structured"
inputs = [v for v in description.modelVariables if v.causality == "input"]
assert len(inputs) == 1 + 4 * 88, len(inputs)
print(f"fmpy: a keyboard of {len(description.modelVariables)} variables, {len(inputs)} of them inputs, no problems")
heard = [tuple(map(float, line.split())) for line in open(f"{chord}/heard.txt")]
pressed = {f"key[{key}].force": 6.0 for key in (40, 44, 47)}
result = simulate_fmu(chord, stop_time=0.1, step_size=1e-3, output_interval=1e-3, fmi_type="CoSimulation",
                      output=["bridge_force", "key[44].key"], start_values={"pedal": 0.007, **pressed})
found = list(zip(result["bridge_force"].tolist(), result["key[44].key"].tolist()))[1:]
assert found == heard, next((n, a, b) for n, (a, b) in enumerate(zip(found, heard)) if a != b)
moved = np.array([(0.0, 0.0, 2), (0.05, 0.005, 2)], dtype=[("time", float), ("key[30].position", float), ("key[30].drive", np.int32)])
result = simulate_fmu(chord, stop_time=0.05, step_size=1e-3, output_interval=1e-3, fmi_type="CoSimulation",
                      output=["key[30].key", "key[31].key"], input=moved)
assert 4e-3 < result["key[30].key"][-1] < 5.2e-3 and abs(result["key[31].key"][-1]) < 1e-9, result[-1]
print(f"keyboard: {len(heard)} forces on the bridge, the same bits")
print("done")
