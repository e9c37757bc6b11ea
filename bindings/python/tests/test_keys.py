"""Keys of a keyboard, played together."""

import erard
import numpy as np
import pytest

NAME = "concert-grand-strings"


def test_a_chord_at_the_bridge() -> None:
    """Each key's force on the bridge, and all else that is read of it, is that of an action of its own, to the bit."""
    keys = erard.Keys(NAME)
    assert len(keys) == 88 and keys.awake < 10 and keys.step_s == 1 / 24000 and keys.time_s == 0.0
    chord = {key: erard.Action(erard.load(f"{NAME}:key={key}")) for key in (40, 44, 47)}
    for key, action in chord.items():
        # The keys have rested together for a while.
        action.restore(keys.save(key))
    keys.set_pedal(0.007)
    for key, action in chord.items():
        keys.drive(key, force=6.0)
        action.set_pedal(0.007)
    impacts, loudest = [], 0.0
    for _ in range(60):
        impacts += keys.step(40)
        for key, action in chord.items():
            for _ in range(40):
                action.step(force=6.0)
            now, own = keys.reading(key), action.reading
            assert (now.bridge_n, now.key_m, now.hammer_rise_m, now.string_n) == (own.bridge_n, own.key_m, own.hammer_rise_m, own.string_n)
            loudest = max(loudest, abs(now.bridge_n))
        assert keys.bridge_n == sum(keys.reading(key).bridge_n for key in range(1, 89))
    assert sorted(key for key, _, _ in impacts) == [40, 44, 47] and loudest > 1.0
    assert all(0.0 < time_s < 0.1 and 1.0 < speed < 6.0 for _, time_s, speed in impacts)
    assert keys.time_s == pytest.approx(0.1) and "88 keys" in repr(keys)


def test_states_are_those_of_an_action() -> None:
    keys, action = erard.Keys("concert-grand"), erard.Action(erard.load("concert-grand:key=30"))
    keys.drive(30, force=5.0)
    keys.step(700)
    saved = keys.save(30)
    action.restore(saved)
    ends = []
    for _ in range(2):
        keys.step(500)
        ends.append(keys.reading(30).hammer_rise_m)
        keys.restore(30, saved)
    played = action.play(np.full(500, 5.0))
    assert ends == [ends[0]] * 2 and played["hammer_rise_m"][-1] == ends[0]
    with pytest.raises(erard.InputError, match="another instrument"):
        keys.restore(31, saved)


def test_hands_and_wrong_inputs() -> None:
    keys = erard.Keys("concert-grand", hand=erard.Hand(mass_kg=0.2))
    action = erard.Action(erard.load("concert-grand:key=50"), hand=erard.Hand(mass_kg=0.2))
    keys.drive(50, force=6.0)
    keys.step(1500)
    for _ in range(1500):
        action.step(force=6.0)
    assert keys.reading(50).key_m == action.reading.key_m and keys.reading(50).hand_m > 1e-3
    keys.place_hand(51, -0.005)
    assert keys.reading(51).hand_m == pytest.approx(-0.005, abs=1e-12)
    for key in (0, 89):
        with pytest.raises(erard.InputError, match="1 to 88"):
            keys.drive(key, force=1.0)
    with pytest.raises(erard.InputError, match="10000 N"):
        keys.drive(1, force=1e9)
    with pytest.raises(erard.InputError, match="no hands"):
        erard.Keys("concert-grand").place_hand(1, 0.0)
    with pytest.raises(erard.InputError, match="harpsichord"):
        erard.Keys("harpsichord")
