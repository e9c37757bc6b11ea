"""Diagnosis of a key from readings on a real piano."""

from __future__ import annotations

import html
import json
from typing import Any, Union

from . import _erard
from ._common import Values, key_of, number, text_of

Reading = Union[float, str, bool, None]


class Diagnosis(Values):
    """Diagnosis of a key: a mapping with the keys of diagnosis.json, shown as text.

    `self["causes"]` lists two causes at most, each more likely than not, in the order of work, with "name",
    "probability", "test" and "cure"; `self["undecided"]` those that the readings leave open; `self["to_do"]` lists the
    work in order, `self["measure_next"]` names the most informative next measurement, `self["readings"]` compares each
    reading with its usual range.

    Attributes
    ----------
    rests_on : str
        Basis of the probabilities.
    is_key_assumed : bool
        Whether no key was given; the usual ranges are then those of C4.
    """

    def __init__(self, answer: dict[str, Any]) -> None:
        self.rests_on: str = answer["rests_on"]
        self.is_key_assumed: bool = answer["is_key_assumed"]
        (self._values,) = answer["keys"]

    def _causes(self) -> list[tuple[str, str, str]]:
        told = [*self["causes"], *self["undecided"]]
        return [(cause["name"], f"{cause['probability']:.0%}", cause["test"]) for cause in told]

    def __repr__(self) -> str:
        causes = [f"  {share:>4}  {name}\n        test: {test}" for name, share, test in self._causes()]
        return "\n".join([f"{self['note']} (key {self['key']}). {self['verdict']}", *causes, *(f"- {line}" for line in self["to_do"])])

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in self._causes())
        caption = html.escape(f"{self['note']} (key {self['key']}). {self['verdict']}")
        work = "".join(f"<li>{html.escape(line)}</li>" for line in self["to_do"])
        return f"<table><caption>{caption}</caption><tr><th>cause</th><th>probability</th><th>test</th></tr>{rows}</table><ol>{work}</ol>"


def diagnose(*, key: int | str | None = None, leads: str | None = None, **readings: Reading) -> Diagnosis:
    """Ranks the possible faults of a real piano's key from its measured readings, as `erard diagnose` does.

    Parameters
    ----------
    key : int or str
        Key, 1 to 88, or its note; by default C4 is assumed.
    leads : str
        Leads in the key, grams at millimetres in front of the balance pin: "14@165, 14@147".
    **readings : float, str or bool
        Readings by the names of the command's options: `down_weight_g=58`, `up_weight_g=18`, `let_off="3.5 mm"`. A
        number is in the unit at the end of the name; `None` means not measured. `balance_weight_g` and
        `friction_weight_g` (`bw`, `f`) may replace one or both of down-weight and up-weight. `measured_at_mm`, `tapped`,
        `dampers_lifted` and `stack_on` (yes or no, or a bool) are the conditions under which the key was weighed.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        If a reading has an unknown name or an impossible value, or if there are no readings; the message lists all
        errors.

    Examples
    --------
    >>> import erard
    >>> found = erard.diagnose(key="C4", down_weight_g=58, up_weight_g=18)
    >>> found["is_work"], len(found["causes"]) <= 2, len(found["undecided"]) > 2
    (True, True, True)
    """
    given = {name: value if value is None or isinstance(value, (bool, str)) else number(name, value) for name, value in readings.items()}
    own = {"key": None if key is None else key_of("key", key), "leads": None if leads is None else text_of("leads", leads)}
    answer = json.loads(_erard.diagnose(json.dumps(own | given)))
    return Diagnosis(answer)
