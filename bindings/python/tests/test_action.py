"""An action stepped from Python."""

import pickle
import threading
from pathlib import Path

import erard
import numpy as np
import pytest


def test_steps_are_those_of_a_press(grand: erard.Instrument) -> None:
    action = erard.Action(grand)
    run = grand.press(force=5.0, duration=0.05)
    key = [0.0] + [action.step(force=5.0).key_m for _ in range(1000)]
    assert np.array_equal(key, run["key_m"][:1001])
    played = erard.Action(grand).play(np.full(1000, 5.0))
    assert np.array_equal(played["key_m"], key[1:]) and set(action.angles) == set(grand.bodies)


def test_goes_on_to_the_bit(grand: erard.Instrument) -> None:
    action = erard.Action(grand, step=1e-4)
    action.play(np.full(300, 6.0))
    saved = action.save()
    copy = pickle.loads(pickle.dumps(action))
    one, two = action.play(np.full(500, 6.0)), copy.play(np.full(500, 6.0))
    assert one == two and copy.step_s == 1e-4
    action.restore(saved)
    assert action.play(np.full(500, 6.0)) == one
    with pytest.raises(erard.InputError, match="another instrument"):
        erard.Action(grand.vary(let_off="-0.2 mm")).restore(saved)
    with pytest.raises(erard.InputError):
        action.restore(saved[:-3])


def test_wrong_inputs(grand: erard.Instrument) -> None:
    action = erard.Action(grand)
    before = action.save()
    # What C refuses, too: more than 10 000 N, 0.1 m, 100 m/s.
    ranges = ({"force": 1e9}, {"force": -10001.0}, {"motion": (0.2, 0.0)}, {"rigid": (0.0, 101.0)})
    for wrong in (*ranges, {"force": float("nan")}, {"motion": (0.0, float("inf"))}, {"force": 1.0, "rigid": (0.0, 0.0)}):
        with pytest.raises(erard.InputError):
            action.step(**wrong)
    with pytest.raises(erard.InputError, match=r"sample 1.*10000 N"):
        action.play([1.0, 1e9])
    assert action.save() == before
    with pytest.raises(erard.InputError, match="step"):
        erard.Action(grand, step=1.0)
    with pytest.raises(TypeError, match="steep"):
        erard.Action(grand, steep=1.0)


def test_two_threads_on_one_action(grand: erard.Instrument) -> None:
    """One waits for the other: all steps are taken, none is lost, and the state is that of as many steps."""
    action, alone = erard.Action(grand), erard.Action(grand)

    def play() -> None:
        for _ in range(50):
            action.play(np.full(100, 5.0))

    threads = [threading.Thread(target=play) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not any(thread.is_alive() for thread in threads)
    alone.play(np.full(10000, 5.0))
    assert action.save() == alone.save()


def test_a_hand_plays(grand: erard.Instrument) -> None:
    """An action with a hand steps as a press by that hand; it pickles with its hand, and a hand is placed anywhere."""
    hand = erard.Hand(mass_kg=0.15, start_m_per_s=0.3)
    run = grand.press(force=5.0, duration=0.1, hand=hand)
    action = erard.Action(grand, hand=hand)
    readings = [action.step(force=5.0) for _ in range(1000)]
    assert np.array_equal([0.0] + [now.key_m for now in readings], run["key_m"][:1001])
    assert readings[-1].hand_m > 0.0 and run.hammer_speed > 0.5
    assert pickle.loads(pickle.dumps(action)).step(force=5.0) == action.step(force=5.0)
    action.place_hand(-0.01)
    assert action.reading.hand_m == pytest.approx(-0.01, abs=1e-12)
    with pytest.raises(erard.InputError, match="has no hand"):
        erard.Action(grand).place_hand(0.0)
    with pytest.raises(erard.InputError, match="mass"):
        erard.Action(grand, hand=erard.Hand(mass_kg=0.0))
    with pytest.raises(erard.InputError, match="Hand"):
        grand.press(force=5.0, hand=0.2)
    with pytest.raises(erard.InputError):
        action.step(rigid=(0.0, 0.0))


def test_a_hand_plays_many(grand: erard.Instrument) -> None:
    hand = erard.Hand()
    study = erard.study(grand, {"let_off": [-1e-4, 0.0, 1e-4]}, force=6.0, duration=0.1, hand=hand)
    alone = [grand.vary(let_off=turned).press(force=6.0, duration=0.1, hand=hand).hammer_speed for turned in (-1e-4, 0.0, 1e-4)]
    assert np.allclose(study["hammer_speed_m_per_s"], alone, rtol=1e-6)


def test_a_sampled_force_is_one_stroke_everywhere(grand: erard.Instrument, tmp_path: Path) -> None:
    """Action, rollout, press and a stroke file interpolate the same samples alike; one number for each step does not."""
    dt, step = 2e-3, 50e-6
    force = np.array([0.0, 0.0, 0.0, 1.0, 3.0, 6.0, 7.0, 6.5, 6.0, 6.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0])
    every, lasts = round(dt / step), dt * (len(force) - 1)
    file = tmp_path / "force.csv"
    file.write_text("time_s,force_N\n" + "".join(f"{k * dt:.3f},{n}\n" for k, n in enumerate(force)))
    played = erard.Action(grand).play(force, dt=dt)
    rolled = erard.rollout(grand, force=force[None], dt=dt, progress=False)
    pressed = grand.press(force=force, dt=dt, duration=lasts, record_every=1, progress=False)
    typed = grand.press(stroke=str(file), duration=lasts, record_every=1, progress=False)
    assert np.array_equal(played["key_m"], pressed["key_m"][1:])
    # The instants of a file are rounded otherwise.
    assert np.allclose(typed["key_m"], pressed["key_m"], rtol=1e-9, atol=1e-15)
    assert np.allclose(played["key_m"][every - 1 :: every], rolled["key_m"][0, 1:], rtol=1e-9)
    held = erard.Action(grand).play(np.repeat(force[:-1], every))
    assert np.abs(held["key_m"] - played["key_m"]).max() > 1e-5
    for wrong, more in [(force[:1], {"dt": dt}), (force, {"dt": 0.0}), (force, {"dt": float("nan")})]:
        with pytest.raises(erard.InputError):
            erard.Action(grand).play(wrong, **more)


def test_a_study_takes_a_tolerance(grand: erard.Instrument) -> None:
    """Adaptive steps give the speeds of presses with the same tolerance; with `single` they are refused."""
    study = erard.study(grand, let_off=[-5e-4, 0.0], force=5.0, tolerance=1e-6, progress=False)
    for row, turn in enumerate([-5e-4, 0.0]):
        alone = grand.vary(let_off=turn).press(force=5.0, tolerance=1e-6, progress=False)
        assert study["hammer_speed_m_per_s"][row] == alone.hammer_speed
    for more in ({"tolerance": 5.0}, {"tolerance": 1e-6, "single": True}):
        with pytest.raises(erard.InputError):
            erard.study(grand, let_off=[0.0], force=5.0, progress=False, **more)
