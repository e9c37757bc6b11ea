"""Causes from one's own readings of a key."""

from __future__ import annotations

import html
import json
from typing import Any, Union

from . import _erard
from ._common import Values

Reading = Union[float, str, None]


class Diagnosis(Values):
    """What may be wrong with a key: a mapping of the keys of diagnosis.json for it, and a text when it is shown.

    `self["causes"]` is a list, the likeliest first, each with "name", "probability", "test" and "cure"; `self["to_do"]` says what to do in which
    order, `self["measure_next"]` what measurement would tell most, `self["readings"]` how each reading lies in its usual range.

    Attributes
    ----------
    rests_on : str
        What the probabilities rest on.
    is_key_assumed : bool
        Whether no key was named, so that usual ranges are those of C4.
    """

    def __init__(self, answer: dict[str, Any]) -> None:
        self.rests_on: str = answer["rests_on"]
        self.is_key_assumed: bool = answer["is_key_assumed"]
        (self._values,) = answer["keys"]

    def _causes(self) -> list[tuple[str, str, str]]:
        return [(cause["name"], f"{cause['probability']:.0%}", cause["test"]) for cause in self["causes"]]

    def __repr__(self) -> str:
        causes = [f"  {share:>4}  {name}\n        test: {test}" for name, share, test in self._causes()]
        return "\n".join([f"{self['note']} (key {self['key']}). {self['verdict']}", *causes, *(f"- {line}" for line in self["to_do"])])

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in self._causes())
        caption = html.escape(f"{self['note']} (key {self['key']}). {self['verdict']}")
        work = "".join(f"<li>{html.escape(line)}</li>" for line in self["to_do"])
        return f"<table><caption>{caption}</caption><tr><th>cause</th><th>probability</th><th>test</th></tr>{rows}</table><ol>{work}</ol>"


def diagnose(*, key: int | str | None = None, leads: str | None = None, **readings: Reading) -> Diagnosis:
    """Ranks what may be wrong with a key of a real piano from whatever was measured of it, as `erard diagnose` does.

    Parameters
    ----------
    key : int or str
        The key, 1 to 88, or its note; without it C4 is assumed.
    leads : str
        Leads in the key, grams at millimetres in front of the balance pin: "14@165, 14@147".
    **readings : float or str
        By the names of the command's options: `down_weight_g=58`, `up_weight_g=18`, `let_off="3.5 mm"`. A number is in the unit at the end of the
        name; `None` was not measured.

    Returns
    -------
    Diagnosis

    Raises
    ------
    InputError
        Where a reading has no such name or cannot be, or none was given: all of them at once.

    Examples
    --------
    >>> import erard
    >>> found = erard.diagnose(key="C4", down_weight_g=58, up_weight_g=18)
    >>> found["is_work"], len(found["causes"]) > 2
    (True, True)
    """
    given = {name: value if value is None or isinstance(value, str) else float(value) for name, value in readings.items()}
    answer = json.loads(_erard.diagnose(json.dumps({"key": key, "leads": leads, **given})))
    return Diagnosis(answer)
