"""A key under a finger that MuJoCo moves, compared with the hand that Erard steps itself."""

import importlib.util
from pathlib import Path
from types import ModuleType

import erard
import pytest

MUSCLE_N, MASS_KG, DURATION_S = 8.0, 0.2, 0.5


@pytest.fixture(scope="module")
def example() -> ModuleType:
    pytest.importorskip("mujoco")
    path = Path(__file__).parents[1] / "examples" / "mujoco_key.py"
    if not path.exists():
        pytest.skip("not in the source tree")
    spec = importlib.util.spec_from_file_location("mujoco_key", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def by_hand() -> tuple[float, float]:
    """Time and hammer speed of the first impact under the same mass and muscle, both inside Erard's step."""
    action = erard.Action(erard.load("concert-grand"), hand=erard.Hand(mass_kg=MASS_KG))
    while True:
        impact = action.step(force=MUSCLE_N).impact
        if impact is not None:
            return impact


def test_a_finger_of_mujoco_strikes_as_erards_own_hand_does(example: ModuleType) -> None:
    """Both have one mass, one muscle and one fingertip. The force of the callback is one step late, so the error is of first order."""
    time_s, speed = by_hand()
    errors = []
    for step_s in (1e-3, 0.5e-3, 0.25e-3):
        keys = example.press(step_s, MUSCLE_N, MASS_KG, DURATION_S)
        _, at_s, with_speed = keys.impacts[0]
        errors.append((abs(at_s - time_s), abs(with_speed / speed - 1)))
    # Not later than the lateness of the force, and a hundredth of the speed at the finest.
    assert errors[2][0] < 0.25e-3
    assert errors[2][1] < 0.01
    for coarse, fine in zip(errors, errors[1:], strict=False):
        assert fine[0] < 0.7 * coarse[0]


def test_a_finger_that_rests_on_a_key_carries_its_muscle(example: ModuleType) -> None:
    """Statics: once nothing moves, the key's force is the muscle's."""
    keys = example.press(0.5e-3, MUSCLE_N, MASS_KG, 1.0)
    assert keys.readings[0].finger_force_n == pytest.approx(MUSCLE_N, rel=1e-3)


def test_what_cannot_be_coupled_is_refused(example: ModuleType) -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(example.FINGER.format(step=1e-3, mass=0.2).replace("implicitfast", "RK4"))
    with pytest.raises(ValueError, match="RK4"):
        example.Keys(model, {})
