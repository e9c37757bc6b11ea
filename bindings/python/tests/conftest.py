"""What the tests share."""

import erard
import numpy as np
import pytest


@pytest.fixture(scope="session")
def grand() -> erard.Instrument:
    return erard.load("concert-grand")


@pytest.fixture(scope="session")
def run() -> erard.Run:
    # Of no other fixture: a module may have a `grand` of its own, and the first to ask would decide what all others
    # get.
    return erard.load("concert-grand").press(force=5.0, duration=0.2)


def pytest_assertrepr_compare(op: str, left: object, right: object) -> list[str] | None:
    """What differs between two tables. pytest would ask their arrays for one truth."""
    if op != "==" or not (isinstance(left, erard.Table) and isinstance(right, erard.Table)):
        return None
    told = [f"{left!r} == {right!r}", f"columns of one only: {', '.join(set(left) ^ set(right)) or 'none'}"]
    for name in left:
        if name in right and not np.array_equal(left[name], right[name], equal_nan=left[name].dtype.kind == "f"):
            told.append(f"{name} differs")
    return told
