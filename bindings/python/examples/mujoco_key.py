"""Erard's keys under a finger that MuJoCo moves: a passive callback.

    python examples/mujoco_key.py              # needs erard, mujoco

MuJoCo has the finger, any mechanism with a joint whose position is the fingertip's depth below the key front's rest (m, down
positive), such as a slide along -z. Erard has the action: friction that sticks, escapement, hammer speed. Both are coupled by
the fingertip of the instrument's file. Whenever MuJoCo asks for passive forces, the action is stepped up to that instant,
along the finger's way since the last one; its force then acts on the joint during MuJoCo's next step. So the force is one step
of MuJoCo late, and the error falls as that step: `tests/test_mujoco.py` compares with the hand that Erard steps itself.
"""

from __future__ import annotations

import erard
import mujoco

FINGER = """<mujoco>
<option timestep="{step}" gravity="0 0 0" integrator="implicitfast"/>
<worldbody><body name="fingertip"><joint name="finger" type="slide" axis="0 0 -1"/><geom type="sphere" size="0.008" mass="{mass}"/></body></worldbody>
<actuator><motor name="muscle" joint="finger"/></actuator>
</mujoco>"""


class Keys:
    """Keys under joints of a model; use it as `mujoco.set_mjcb_passive(keys)`, and for one `MjData` only.

    Parameters
    ----------
    model : mujoco.MjModel
        With any integrator but RK4, which asks for forces at instants that it then discards.
    actions : dict of str to erard.Action
        By the name of the joint that presses; each at rest.
    """

    def __init__(self, model: mujoco.MjModel, actions: dict[str, erard.Action]) -> None:
        if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
            raise ValueError("the model's integrator is RK4, which tries instants and goes back; expected Euler, implicit or implicitfast")
        self._keys = [(model.joint(name).qposadr[0], model.joint(name).dofadr[0], action) for name, action in actions.items()]
        self._before: dict[int, float] = {}
        self._time_s = 0.0
        #: What each action did last, in the order of `actions`; None before the first step.
        self.readings: list[erard.Reading | None] = [None] * len(self._keys)
        #: Impacts so far: key (its place in `actions`), time from the action's start in s, hammer speed in m/s.
        self.impacts: list[tuple[int, float, float]] = []

    def __call__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        elapsed = data.time - self._time_s
        if elapsed < 0:
            raise RuntimeError("MuJoCo's time ran backward: make new actions and a new Keys after mj_resetData")
        for at, (position, velocity, action) in enumerate(self._keys):
            now_m, now_m_per_s = data.qpos[position], data.qvel[velocity]
            before_m = self._before.get(at, now_m)
            count = round((data.time - self._steps_s(at, action)) / action.step_s)
            for n in range(count):
                # In the middle of the step, along the straight way that the finger went.
                share = (n + 0.5) / count
                reading = action.step(motion=(before_m + share * (now_m - before_m), (now_m - before_m) / elapsed))
                self.readings[at] = reading
                if reading.impact is not None:
                    self.impacts.append((at, *reading.impact))
            self._before[at] = now_m
            if (last := self.readings[at]) is not None:
                data.qfrc_passive[velocity] -= last.finger_force_n
        self._time_s = data.time

    def _steps_s(self, at: int, action: erard.Action) -> float:
        last = self.readings[at]
        return 0.0 if last is None else last.time_s


def press(step_s: float, muscle_n: float, mass_kg: float = 0.2, duration_s: float = 0.5, instrument: str = "concert-grand") -> Keys:
    """A finger of a mass, driven down by a constant muscle force, presses a key; returns what the key did."""
    model = mujoco.MjModel.from_xml_string(FINGER.format(step=step_s, mass=mass_kg))
    data = mujoco.MjData(model)
    keys = Keys(model, {"finger": erard.Action(erard.load(instrument))})
    mujoco.set_mjcb_passive(keys)
    try:
        data.ctrl[0] = muscle_n
        while data.time < duration_s:
            mujoco.mj_step(model, data)
    finally:
        mujoco.set_mjcb_passive(None)
    return keys


if __name__ == "__main__":
    for step_s in (1e-3, 0.5e-3, 0.25e-3):
        keys = press(step_s, muscle_n=8.0)
        _, time_s, speed = keys.impacts[0]
        print(f"step {1e3 * step_s:.2f} ms: impact at {1e3 * time_s:.2f} ms with {speed:.3f} m/s; then {keys.readings[0].finger_force_n:.3f} N on the key")
