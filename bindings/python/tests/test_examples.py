"""The examples in the documentation run."""

import doctest
import importlib
import inspect
import pkgutil
from pathlib import Path

import erard
import pytest

MODULES = [erard.__name__] + [f"erard.{module.name}" for module in pkgutil.iter_modules(erard.__path__) if module.name != "_erard"]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name: str) -> None:
    module = importlib.import_module(name)
    failed, _ = doctest.testmod(module, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


@pytest.mark.parametrize("folder", ["bindings/python", "."])
def test_the_readme_runs(folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first Python block of this package's README and of the project's."""
    readme = Path(__file__).parents[3] / folder / "README.md"
    if not readme.exists():
        pytest.skip("not in the source tree")
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    block = readme.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    exec(compile(block, "README.md", "exec"), {})


def public() -> list[str]:
    """Functions and methods that users call, by their full names."""
    found = []
    for name in erard.__all__:
        one = getattr(erard, name)
        if inspect.ismodule(one):
            own = {key: value for key, value in vars(one).items() if inspect.isfunction(value) and value.__module__ == one.__name__}
            found += [f"{one.__name__}.{key}" for key in own if not key.startswith("_")]
        elif inspect.isclass(one):
            own = {key: value for key, value in vars(one).items() if inspect.isfunction(value)}
            found += [f"erard.{name}.{key}" for key in own if not key.startswith("_")]
        else:
            found.append(f"erard.{name}")
    return found


@pytest.mark.parametrize("name", public())
def test_documentation_is_whole(name: str) -> None:
    """numpydoc finds every parameter and what comes back: none is missing, none too many."""
    validate = pytest.importorskip("numpydoc.validate")
    wrong = [told for code, told in validate.validate(name)["errors"] if code in ("GL08", "PR01", "PR02", "RT01")]
    assert not wrong


def test_what_is_public_has_an_example_or_is_part_of_one() -> None:
    """Every public function and class says what it does; every function of the package runs in an example."""
    for name in erard.__all__:
        assert getattr(erard, name).__doc__, name
    text = "".join(importlib.import_module(name).__doc__ or "" for name in MODULES)
    for name in MODULES:
        module = importlib.import_module(name)
        text += "".join(test.docstring or "" for test in doctest.DocTestFinder().find(module))
    for call in ("load(", ".press(", ".vary(", "rollout(", "study(", ".measure(", ".regulate(", "Action(", ".compare(", "kinematics(", "keyboard(", ".draw(", "gradient("):
        assert call in text, call
