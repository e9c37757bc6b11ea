"""Bad arguments by chance: `attack.py` draws calls from the functions' own signatures."""

import subprocess
import sys

import attack
import pytest


def attacked(first: int, last: int) -> str:
    """Makes the calls of the seeds from the first to before the last, in a process of its own: one that dies is a fault, too."""
    done = subprocess.run([sys.executable, attack.__file__, str(first), str(last)], capture_output=True, text=True)
    said = "\n".join(line for line in done.stdout.splitlines() if not line.startswith("at "))
    assert done.returncode == 0 and "ends: " in said, f"{said}\nafter {done.stdout.splitlines()[-1:]}: {done.stderr[-2000:]}"
    return said


def test_every_function_is_attacked() -> None:
    """Those that take anything; and what the attack knows how to call is there."""
    assert len(attack.targets()) >= 40
    for name in attack.OWN:
        assert name in attack.targets(), name
    assert {attack.call(seed)[0].partition("(")[0] for seed in range(len(attack.targets()))} == set(attack.targets())


def test_bad_arguments_are_refused_in_words() -> None:
    attacked(0, 75)


@pytest.mark.nightly
@pytest.mark.parametrize("first", range(1000, 3000, 250))
def test_more_bad_arguments_are_refused_in_words(first: int) -> None:
    attacked(first, first + 250)


def test_a_new_function_is_attacked(monkeypatch: pytest.MonkeyPatch) -> None:
    """The attack finds what was added, and ends the test where it does not know how to call it."""

    def added(strange: object) -> None:
        """Takes what the attack does not know."""

    monkeypatch.setattr(attack.erard, "added", added, raising=False)
    monkeypatch.setattr(attack.erard, "__all__", [*attack.erard.__all__, "added"])
    place = sorted(attack.targets()).index("added")
    monkeypatch.setattr(attack.random.Random, "sample", lambda *_: [])
    with pytest.raises(LookupError, match="strange"):
        attack.call(place)


