"""The notebooks run from top to bottom."""

import os
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.py"))
#: Those that fit, and play a thousand strokes: the longest.
LONG = ("4", "5", "7")


@pytest.mark.parametrize(
    "path", [pytest.param(path, id=path.stem, marks=[pytest.mark.nightly] if path.stem.startswith(LONG) else []) for path in NOTEBOOKS]
)
def test_notebook(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    jupytext = pytest.importorskip("jupytext")
    nbclient = pytest.importorskip("nbclient")
    monkeypatch.setenv("ERARD_STROKES", "1000")
    monkeypatch.setenv("ERARD_RECORDINGS", os.fspath(Path(__file__).parents[3] / "recordings"))
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    notebook = jupytext.read(path)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": os.fspath(tmp_path)}}).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells and all(cell.execution_count for cell in cells)
    for cell in cells:
        images = [output for output in cell.outputs if "image/png" in output.get("data", {})]
        assert len(images) == 1 if cell.source.rstrip().endswith("plot()") else len(images) <= 1, cell.source


def test_all_seven_are_there() -> None:
    assert [path.stem[0] for path in NOTEBOOKS] == list("1234567")
