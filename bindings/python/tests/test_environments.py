"""Environments for Gymnasium: their bits are an action's, a reset goes back to the bit, many are as each alone."""

import sys
import warnings
from pathlib import Path

import erard
import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from erard.environments import KeyEnv, KeyVectorEnv  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

#: Forces, N, and velocities of the fingertip, m/s, of 60 periods.
ASKED = {"force": 5.0 + 2.0 * np.sin(np.arange(60) / 7), "motion": 0.16 + 0.1 * np.sin(np.arange(60) / 9)}


def played(env: KeyEnv, asked: np.ndarray) -> list[tuple[bytes, float, bool, bool]]:
    steps = (env.step([one]) for one in asked)
    return [(seen.tobytes(), reward, ended, cut) for seen, reward, ended, cut, _ in steps]


@pytest.mark.parametrize("control", ["force", "motion"])
@pytest.mark.parametrize("hand", [None, erard.Hand()])
def test_gymnasium_finds_nothing_wrong(control: str, hand: erard.Hand | None) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Forces are in newtons, and a finger only pushes.
        warnings.filterwarnings("ignore", message=".*symmetric and normalized space")
        check_env(gymnasium.make("erard/Key-v0", control=control, hand=hand).unwrapped)


@pytest.mark.parametrize("hand", [None, erard.Hand(mass_kg=0.15)])
def test_the_bits_are_an_actions(grand: erard.Instrument, hand: erard.Hand | None) -> None:
    env, action = KeyEnv(grand, hand=hand), erard.Action(grand, hand=hand)
    env.reset(seed=1)
    impacts = 0
    for force in ASKED["force"]:
        seen, reward, ended, _, info = env.step([force])
        readings = [action.step(force=force) for _ in range(20)]
        now, mean = readings[-1], sum(one.finger_force_n for one in readings) / 20
        expected = [now.key_m, now.key_m_per_s, mean, now.hammer_rise_m, now.hammer_rise_m_per_s, now.hand_m]
        assert seen[:6].tolist() == expected
        assert env.save()["state"] == action.save()
        for impact in (one.impact for one in readings if one.impact):
            impacts += 1
            assert ended and info == {"hammer_speed_m_per_s": impact[1]} and reward == 1.0 - abs(impact[1] / seen[6] - 1.0)
    assert impacts == 1


def test_a_fingertip_moves_on_within_its_period(grand: erard.Instrument) -> None:
    env, action = KeyEnv(grand, control="motion", period_s=2e-3, step=50e-6), erard.Action(grand)
    env.reset(seed=1)
    at_m = 0.0
    for velocity in ASKED["motion"][:30]:
        seen, *_ = env.step([velocity])
        to_m = at_m + velocity * 2e-3
        actual = (to_m - at_m) / 2e-3
        for n in range(40):
            action.step(motion=(at_m + actual * (n * 50e-6 + 0.5 * 50e-6), actual))
        at_m = to_m
        assert env.save()["state"] == action.save() and seen[5] == at_m
    assert action.reading.key_m > 5e-3


@pytest.mark.parametrize("control", ["force", "motion"])
def test_a_reset_goes_back_to_the_bit(grand: erard.Instrument, control: str) -> None:
    asked, env = ASKED[control], KeyEnv(grand, control=control)
    first = env.reset(seed=7)[0]
    assert 0.5 <= first[6] <= 4.0 and env.reset(seed=7)[0].tobytes() == first.tobytes()
    assert env.reset()[0][6] != first[6]
    env.reset(seed=7)
    played(env, asked[:20])
    saved = env.save()
    rest = played(env, asked[20:])
    seen, _ = env.reset(options=saved)
    assert seen.tobytes() == KeyEnv(grand, control=control).reset(options=saved)[0].tobytes()
    assert played(env, asked[20:]) == rest and any(ended for _, _, ended, _ in rest)
    # A new episode of the same seed is the first one.
    whole = [played(env, asked) for _ in range(2) if env.reset(seed=7)]
    assert whole[0] == whole[1] and whole[0][20:] == rest


@pytest.mark.parametrize("control", ["force", "motion"])
def test_many_are_as_each_alone(grand: erard.Instrument, control: str) -> None:
    """Whose episodes end begins anew in the next step; another number of threads makes no difference."""
    count, short = 6, {"control": control, "duration_s": 0.03}
    own = [grand, grand.vary({"body.hammer.mass": "+1 g"})] * 3
    several = [KeyVectorEnv(count, own, threads=threads, **short) for threads in (1, 2)]
    alone = [KeyEnv(one, **short) for one in own]
    starts = [envs.reset(seed=3)[0] for envs in several]
    assert starts[0].tobytes() == starts[1].tobytes() == np.array([env.reset(seed=3 + n)[0] for n, env in enumerate(alone)]).tobytes()
    over, impacts = [False] * count, 0
    for asked in ASKED[control]:
        # Louder from lane to lane.
        actions = asked * np.linspace(0.7, 2.0, count)[:, None]
        found, again = (envs.step(actions) for envs in several)
        assert all(one.tobytes() == other.tobytes() for one, other in zip(found[:4], again[:4], strict=True))
        for n, env in enumerate(alone):
            begun = (env.reset()[0], 0.0, False, False, {}) if over[n] else None
            seen, reward, ended, cut, info = begun or env.step(actions[n])
            assert (found[0][n].tobytes(), found[1][n], found[2][n], found[3][n]) == (seen.tobytes(), reward, ended, cut)
            assert ("hammer_speed_m_per_s" in info) == bool(found[4].get("_hammer_speed_m_per_s", np.zeros(count))[n])
            impacts += "hammer_speed_m_per_s" in info
            over[n] = ended or cut
    assert impacts >= 3
    assert several[0].reset(options=several[1].save())[0].tobytes() == several[1].reset(options=several[1].save())[0].tobytes()


def test_an_episode_begins_where_it_is_asked_to(grand: erard.Instrument) -> None:
    """A checked hammer, a reward of one's own, one key of a keyboard."""
    action = erard.Action(grand)
    action.play(np.full(4000, 6.0))
    env = KeyEnv(grand, begin=action.save(), reward=lambda now, goal: -now["finger_force_mean_n"], duration_s=0.05)
    seen, _ = env.reset(seed=1)
    assert seen[0] == action.reading.key_m > 8e-3 and seen[7] == 0.0
    found = [env.step([0.0]) for _ in range(50)]
    assert found[0][1] == 0.0 and [one[3] for one in found] == [False] * 49 + [True]
    assert not any(one[2] for one in found) and found[-1][0][0] < 1e-3


def test_what_is_wrong_is_named(grand: erard.Instrument) -> None:
    for wrong, key in (
        ({"control": "push"}, "control"),
        ({"period_s": 1.0}, "period_s"),
        ({"duration_s": 1e-6}, "duration_s"),
        ({"goal_m_per_s": (2.0, 1.0)}, "goal_m_per_s"),
        ({"begin": b"nothing"}, None),
    ):
        with pytest.raises(erard.InputError) as caught:
            KeyEnv(grand, **wrong)
        assert caught.value.key == key, wrong
    env = KeyEnv(grand)
    for action in ([float("nan")], [1.0, 2.0], "loud"):
        with pytest.raises(erard.InputError, match="action"):
            env.step(action)
    for options in ({"stat": b""}, {"goal_m_per_s": -1.0}, {"state": b"x"}):
        with pytest.raises(erard.InputError):
            env.reset(options=options)
    with pytest.raises(erard.InputError, match="found 1 instruments"):
        KeyVectorEnv(2, [grand])


def test_the_readmes_agent_plays(capsys: pytest.CaptureFixture[str]) -> None:
    readme = Path(__file__).parents[1] / "README.md"
    block = readme.read_text(encoding="utf-8").split("## Agents that play")[1].split("```python\n")[1].split("```")[0]
    exec(compile(block, "README.md", "exec"), {})
    assert 0.5 < float(capsys.readouterr().out) < 2.0


@pytest.mark.parametrize(("module", "extra", "call"), [
    ("scipy.optimize", "scipy", lambda grand, run: erard.fit(grand, run, parameters=["body.hammer.mass"], minimizer="scipy")),
    ("pandas", "tables", lambda grand, run: run.to_pandas()),
    ("matplotlib.pyplot", "plot", lambda grand, run: run.plot()),
])  # fmt: skip
def test_what_is_not_installed_is_named(
    grand: erard.Instrument, run: erard.Run, module: str, extra: str, call: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ModuleNotFoundError, match=rf"{module} is not installed: pip install 'erard\[{extra}\]'"):
        call(grand, run)
