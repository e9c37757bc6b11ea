"""Simulation of the grand piano action.

>>> import erard
>>> grand = erard.load("concert-grand")
>>> run = grand.press(force=5.0)
>>> run.hammer_speed > 1.0, "let_off" in run.events
(True, True)

All units are SI: s, N, m, rad. Forces and positions of key and finger are positive downward (pushing), those of the
hammer upward. A column's name ends with its unit. Some parts need extras: figures need `pip install erard[plot]`,
`erard.sample` needs `erard[bayes]`, `erard.distributed` needs `erard[distributed]` and `erard.environments` (Gymnasium)
needs `erard[gymnasium]`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._action import Action
from ._common import Hand, unit_of
from ._diagnose import Diagnosis, diagnose
from ._errors import DoubtfulFitWarning, FailedStrokesWarning, InputError, MissingFileError, SimulationError
from ._gradient import Gradient, gradient
from ._instrument import (
    Comparison,
    Drawing,
    Instrument,
    Keyboard,
    Kinematics,
    Parameter,
    Sheet,
    builtin,
    keyboard,
    kinematics,
    load,
)
from ._keys import Keys
from ._many import Rollout, Study, rollout, study
from ._recording import Recording
from ._run import Run
from ._table import Table
from ._version import __version__

if TYPE_CHECKING:
    from . import dataset as dataset
    from . import distributed as distributed
    from . import environments as environments
    from . import judge as judge
    from ._fit import Doubt, Fit, fit
    from ._posterior import Posterior, sample

__all__ = [
    "Action",
    "Comparison",
    "Diagnosis",
    "Doubt",
    "DoubtfulFitWarning",
    "FailedStrokesWarning",
    "Drawing",
    "Fit",
    "Gradient",
    "Hand",
    "InputError",
    "Instrument",
    "Keyboard",
    "Keys",
    "Kinematics",
    "MissingFileError",
    "Parameter",
    "Posterior",
    "Recording",
    "Rollout",
    "Run",
    "Sheet",
    "SimulationError",
    "Study",
    "Table",
    "builtin",
    "dataset",
    "diagnose",
    "distributed",
    "environments",
    "fit",
    "gradient",
    "judge",
    "keyboard",
    "kinematics",
    "load",
    "rollout",
    "sample",
    "study",
    "unit_of",
]

#: Names that are imported on first use.
_LATER = {"fit": "_fit", "Fit": "_fit", "Doubt": "_fit", "sample": "_posterior", "Posterior": "_posterior"}


def __getattr__(name: str) -> Any:
    import importlib

    if name in _LATER:
        return getattr(importlib.import_module(f".{_LATER[name]}", __name__), name)
    if name in ("dataset", "distributed", "environments", "judge"):
        return importlib.import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
