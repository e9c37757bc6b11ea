"""What sticks in MuJoCo: `sticks.py` prints drifts over ten seconds as a table in Markdown.

Two problems that friction holds at rest, each by a wide margin: a block on a slope of 20 degrees, and a cylinder that two pads pinch.
MuJoCo's contacts do the work, with the settings that its documentation names against slip. The same two problems in Erard's general
step: `cargo run --release -p moreau-rigid --example sticks`. See docs/notes/sticks.md.
"""

import itertools
import math

import mujoco

# The same numbers as in crates/moreau-rigid/examples/sticks.rs.
SLOPE_DEG, FRICTION, GRAVITY = 20.0, 0.5, 9.81
FROM_S, UNTIL_S = 1.0, 10.0

# A block of 20 x 4 cm on a plane that is tilted by tilting gravity.
BLOCK = f"""
<mujoco>
  <option gravity="{-GRAVITY * math.sin(math.radians(SLOPE_DEG))} 0 {-GRAVITY * math.cos(math.radians(SLOPE_DEG))}"/>
  <default><geom friction="{FRICTION} 0 0" condim="3"/></default>
  <worldbody>
    <geom type="plane" size="9 9 1"/>
    <body pos="0 0 0.02"><freejoint/><geom type="box" size="0.1 0.1 0.02" mass="0.5"/></body>
  </worldbody>
</mujoco>"""

# A cylinder of 4 cm and 0.1 kg between a wall and a pad that pushes with 5 N: friction can carry 5 N, it weighs 0.98 N.
PINCHED = f"""
<mujoco>
  <option gravity="0 0 {-GRAVITY}"/>
  <default><geom friction="{FRICTION} 0 0" condim="3"/></default>
  <worldbody>
    <geom type="box" size="0.02 0.1 0.1" pos="-0.04 0 0"/>
    <body><freejoint/><geom type="cylinder" size="0.02 0.05" euler="90 0 0" mass="0.1"/></body>
    <body pos="0.04 0 0"><joint name="pad" type="slide" axis="1 0 0"/><geom type="box" size="0.02 0.1 0.1" mass="0.1"/></body>
  </worldbody>
  <actuator><motor joint="pad" ctrllimited="false"/></actuator>
</mujoco>"""

INTEGRATORS = ["Euler", "implicitfast", "discrete"]
# Cone, ratio of frictional to normal impedance, sweeps against slip.
CONTACTS = [("pyramidal", 1.0, 0), ("elliptic", 1.0, 0), ("elliptic", 100.0, 0), ("elliptic", 1.0, 30)]
STEPS_S = [2e-3, 5e-4]


def drift_m(xml, body, axis, force, integrator, contact, step):
    """How far a body goes between the first second and the tenth, m; not a number if it fell."""
    model = mujoco.MjModel.from_xml_string(xml)
    cone, impratio, noslip = contact
    option = model.opt
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{cone.upper()}")
    option.impratio, option.noslip_iterations, option.timestep = impratio, noslip, step
    data = mujoco.MjData(model)
    if model.nu:
        data.ctrl[0] = force
    mujoco.mj_step(model, data, nstep=round(FROM_S / step))
    start = data.xpos[body][axis]
    mujoco.mj_step(model, data, nstep=round((UNTIL_S - FROM_S) / step))
    return abs(data.xpos[body][axis] - start)


def shown(metres):
    return f"{1e3 * metres:.2g}" if metres < 0.05 else "falls"


def main():
    print(f"MuJoCo {mujoco.__version__}: drift from {FROM_S:g} to {UNTIL_S:g} s, mm\n")
    print("| integrator | cone | impratio | noslip sweeps | step, ms | block on a slope | pinched cylinder |")
    print("|---|---|---|---|---|---|---|")
    for integrator, contact, step in itertools.product(INTEGRATORS, CONTACTS, STEPS_S):
        block = drift_m(BLOCK, 1, 0, 0.0, integrator, contact, step)
        pinched = drift_m(PINCHED, 1, 2, -5.0, integrator, contact, step)
        cone, impratio, noslip = contact
        print(f"| {integrator} | {cone} | {impratio:g} | {noslip} | {1e3 * step:g} | {shown(block)} | {shown(pinched)} |", flush=True)


if __name__ == "__main__":
    main()
