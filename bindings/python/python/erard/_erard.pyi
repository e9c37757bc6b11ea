"""Extension in Rust, which only converts arguments and results. Use the package `erard` instead."""

from collections.abc import Callable
from typing import Any, final

from ._types import Change, Fitted, Floats, Progress, Ready, Steps, Work

__all__ = [
    "Action",
    "Instrument",
    "Keys",
    "Problem",
    "Reading",
    "Recording",
    "Stroke",
    "advance",
    "builtin",
    "compare",
    "diagnose",
    "draw",
    "figure",
    "gradient",
    "keyboard",
    "kinematics",
    "measure",
    "measure_lines",
    "play_all",
    "press",
    "regulate",
    "rollout",
    "study",
    "unit",
    "validate",
]

@final
class Instrument:
    def __new__(cls, text: str, file_name: str, changes: list[Change]) -> Instrument: ...
    @staticmethod
    def load(asked: str) -> Instrument: ...
    @property
    def name(self) -> str: ...
    @property
    def usual_step_s(self) -> float: ...
    @property
    def description(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def file_name(self) -> str: ...
    @property
    def changes(self) -> list[Change]: ...
    @property
    def bodies(self) -> list[str]: ...
    @property
    def zones(self) -> list[str]: ...
    @property
    def screws(self) -> list[tuple[str, str]]: ...
    def quantities(self) -> list[dict[str, Any]]: ...
    def varied(self, changes: list[Change]) -> Instrument: ...
    def number_at(self, path: str) -> float | None: ...
    def equals(self, other: Instrument) -> bool: ...

@final
class Stroke:
    @staticmethod
    def constant(force_n: float) -> Stroke: ...
    @staticmethod
    def samples(kind: str, values: Floats, dt: float) -> Stroke: ...
    @staticmethod
    def level(instrument: Instrument, name: str, speed_m_per_s: float | None, touch: str, mass_kg: float) -> Stroke: ...
    @staticmethod
    def curve(nuance: str, touch: str, drive: str | None) -> Stroke: ...
    @staticmethod
    def recorded(recording: Recording, drive: str | None) -> Stroke: ...
    @property
    def title(self) -> str: ...
    @property
    def drive(self) -> str: ...
    @property
    def start_s(self) -> float: ...
    @property
    def duration_s(self) -> float: ...
    @property
    def note(self) -> str | None: ...

@final
class Recording:
    @staticmethod
    def load(path: str, columns: str | None, ready: Ready) -> Recording: ...
    @staticmethod
    def table(
        name: str,
        titles: list[str],
        values: list[Floats],
        columns: str | None,
        ready: Ready,
    ) -> Recording: ...
    @property
    def name(self) -> str: ...
    @property
    def position_of(self) -> str: ...
    @property
    def notes(self) -> list[str]: ...
    def columns(self) -> dict[str, Floats]: ...
    def at(self, name: str, times: Floats) -> Floats | None: ...
    def noise(self, name: str) -> float | None: ...

@final
class Problem:
    def __new__(
        cls,
        instrument: Instrument,
        vary: list[str],
        bounds: list[tuple[str, tuple[float, float]]],
        recordings: list[Recording],
        drive: str | None,
        columns: list[str] | None,
        delay: bool,
        sigma: list[tuple[str, float]],
        steps: Steps,
        threads: int | None,
    ) -> Problem: ...
    def fit(
        self,
        asked: tuple[list[tuple[str, float]], str, str, int, int],
        solver: Callable[..., tuple[list[float], list[float], str]] | None,
        progress: Callable[[int], None] | None,
    ) -> Fitted: ...
    def curves(self, point: list[float]) -> list[tuple[str, int, str, Floats, Floats, Floats, float, float]]: ...
    def residuals(self, points: Floats, progress: Callable[[int], None] | None = None) -> Floats: ...
    def jacobian(self, point: list[float], exact: bool) -> Floats: ...
    def bounds(self) -> tuple[list[float], list[float]]: ...
    def outer(self, points: Floats) -> Floats: ...
    def sigma(self) -> list[float]: ...
    def set_sigma(self, sigma: list[float]) -> None: ...

@final
class Reading:
    def __new__(
        cls,
        time_s: float,
        key_m: float,
        key_m_per_s: float,
        finger_n: float,
        hammer_m: float,
        hammer_m_per_s: float,
        string_n: float,
        hand_m: float,
        hand_m_per_s: float,
        bridge_n: float,
        converged: bool,
        impact: tuple[float, float] | None,
    ) -> Reading: ...
    def __getnewargs__(
        self,
    ) -> tuple[float, float, float, float, float, float, float, float, float, float, bool, tuple[float, float] | None]: ...
    time_s: float
    key_m: float
    key_m_per_s: float
    finger_n: float
    hammer_m: float
    hammer_m_per_s: float
    string_n: float
    hand_m: float
    hand_m_per_s: float
    bridge_n: float
    converged: bool
    impact: tuple[float, float] | None

@final
class Action:
    def __new__(cls, instrument: Instrument, steps: Steps) -> Action: ...
    def step_s(self) -> float: ...
    def step(
        self, force: float | None, motion: tuple[float, float] | None, rigid: tuple[float, float] | None
    ) -> Reading: ...
    def place_hand(self, position_m: float, velocity_m_per_s: float) -> None: ...
    def set_pedal(self, lift_m: float) -> None: ...
    def play(self, forces: Floats) -> dict[str, Floats]: ...
    def reading(self) -> Reading: ...
    def angles(self) -> Floats: ...
    def velocities(self) -> Floats: ...
    def contact_forces(self) -> Floats: ...
    def save(self) -> bytes: ...
    def restore(self, saved: bytes) -> None: ...

@final
class Keys:
    def __new__(cls, asked: str, steps: Steps) -> Keys: ...
    def count(self) -> int: ...
    def awake(self) -> int: ...
    def step_s(self) -> float: ...
    def time_s(self) -> float: ...
    def drive(
        self, key: int, force: float | None, motion: tuple[float, float] | None, rigid: tuple[float, float] | None
    ) -> None: ...
    def place_hand(self, key: int, position_m: float, velocity_m_per_s: float) -> None: ...
    def set_pedal(self, lift_m: float) -> None: ...
    def step(self, steps: int) -> list[tuple[int, float, float]]: ...
    def reading(self, key: int) -> Reading: ...
    def bridge_n(self) -> float: ...
    def save(self, key: int) -> bytes: ...
    def restore(self, key: int, saved: bytes) -> None: ...

def advance(
    actions: list[Action],
    kind: str,
    values: Floats,
    steps: int,
    threads: int | None,
) -> dict[str, Floats]: ...
def builtin() -> tuple[list[str], list[str], list[str], list[str]]: ...
def unit(name: str) -> str: ...
def press(
    instrument: Instrument,
    stroke: Stroke,
    steps: Steps,
    model: str,
    duration: float | None,
    record_every: int | None,
    tolerance: float | None,
    reactions: bool,
    losses: bool,
    progress: Progress,
) -> tuple[dict[str, Floats], dict[str, Any]]: ...
def gradient(
    instrument: Instrument,
    by: list[tuple[str, tuple[Instrument, Instrument, float] | None]],
    stroke: Stroke,
    duration: float | None,
    steps: Steps,
    every: int | None,
    how: tuple[bool, bool, bool, list[str]],
    threads: int | None,
    progress: Progress,
) -> dict[str, Any]: ...
def figure(columns: dict[str, Floats], about: dict[str, Any], title: str) -> str: ...
def rollout(
    instruments: list[Instrument], kind: str, values: Floats, dt: float, steps: Steps, work: Work, progress: Progress
) -> dict[str, Any]: ...
def play_all(
    instruments: list[Instrument],
    strokes: list[Stroke],
    jobs: list[tuple[int, int]],
    duration: float | None,
    steps: Steps,
    work: Work,
    progress: Progress,
) -> dict[str, Any]: ...
def study(
    instrument: Instrument,
    names: list[str],
    values: Floats,
    stroke: Stroke | None,
    forces: Floats | None,
    duration: float | None,
    steps: Steps,
    work: Work,
    progress: Progress,
) -> dict[str, Any]: ...
def diagnose(readings: str) -> str: ...
def measure_lines() -> list[tuple[str, str, str, int, str]]: ...
def measure(instrument: Instrument, key: int | None, only: list[str] | None, progress: Progress) -> str: ...
def regulate(
    instrument: Instrument, goals: list[Change], norms: bool, follow: bool, progress: Progress
) -> tuple[Instrument, dict[str, Any]]: ...
def kinematics(
    instrument: Instrument | None, linkage: str | None, from_m: float, to_m: float | None, steps: int
) -> tuple[dict[str, Floats], dict[str, Any]]: ...
def keyboard(asked: str, keys: list[int], progress: Progress) -> tuple[str, dict[str, Any]]: ...
def draw(
    instrument: Instrument,
    stroke: Stroke,
    at_s: float,
    steps: Steps,
    labels: bool,
    forces: bool,
    caption: str,
) -> str: ...
def compare(
    instrument: Instrument,
    recording: Recording,
    drives: list[str] | None,
    models: list[str] | None,
    duration: float | None,
    steps: Steps,
    progress: Progress,
) -> tuple[dict[str, Floats], list[dict[str, Any]], list[str]]: ...
def validate(instrument: Instrument, progress: Progress) -> list[dict[str, Any]]: ...
