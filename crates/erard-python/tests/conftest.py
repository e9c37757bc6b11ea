"""What the tests share."""

import erard
import pytest


@pytest.fixture(scope="session")
def grand() -> erard.Instrument:
    return erard.load("concert-grand")


@pytest.fixture(scope="session")
def run(grand: erard.Instrument) -> erard.Run:
    return grand.press(force=5.0, duration=0.2)
