"""The walk-through under docs/ is what this code does: executed, its outputs compared."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from html import unescape
from pathlib import Path
from typing import Any

import nbformat
import pytest

import bayescal as bc
from bayescal.comparison.results import Comparison
from tests.helpers.command import environment
from tests.helpers.notebook import WALKTHROUGH

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def stored() -> Any:
    return nbformat.read(WALKTHROUGH, as_version=4)


@pytest.fixture(scope="module")
def executed(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The same notebook, run in a process of its own: a kernel's client has threads and loops."""
    copy = tmp_path_factory.mktemp("walkthrough") / "copy.ipynb"
    copy.write_bytes(WALKTHROUGH.read_bytes())
    done = subprocess.run(
        [sys.executable, "-m", "tests.helpers.notebook", str(copy)],
        cwd=Path(__file__).resolve().parents[1],
        env=environment(),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return nbformat.read(copy, as_version=4)


def code(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def texts(cell: Any) -> list[str]:
    """What a cell printed and showed, HTML as its text; a figure is only named."""
    out = []
    for output in cell.outputs:
        data = output.get("data", {})
        if "text/html" in data:
            out.append(unescape(re.sub(r"<[^>]*>", " ", data["text/html"])))
        elif "image/png" in data:
            out.append("a figure")
        else:
            out.append(output.get("text") or data["text/plain"])
    return out


def same(one: str, other: str) -> bool:
    """Whether texts have the same words, and numbers alike to a unit of the last digit."""
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    return all(
        abs(float(a) - float(b)) <= 1.001 * 10.0 ** -len(a.partition(".")[2])
        for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    )


def test_outputs_are_what_this_code_gives(stored: Any, executed: Any) -> None:
    for kept, made in zip(code(stored), code(executed), strict=True):
        assert kept.source == made.source
        for one, other in zip(texts(kept), texts(made), strict=True):
            assert same(one, other), f"{kept.source}\n{one}\n{other}\nrun ./scripts/walkthrough"


def test_the_comparison_of_outputs_can_fail() -> None:
    """Negative control."""
    assert same("ln B 1.69 (positive)", "ln B 1.70 (positive)")
    assert not same("ln B 1.69 (positive)", "ln B 1.72 (positive)")
    assert not same("order 4", "orders 4")
    assert not same("0.5", "-0.5")


def test_key_numbers_are_those_of_the_library(stored: Any, thesis_comparison: Comparison) -> None:
    shown = "\n".join(text for cell in code(stored) for text in texts(cell))
    for name, axis in thesis_comparison.axes.items():
        assert axis.verdict.text in shown
        factor = axis.verdict.log_bayes_factor_to_next
        assert f"{name}: order {axis.verdict.order}" in shown
        assert f"ln B {factor:.2f}" in shown


def test_every_cell_of_code_shows_something_and_none_an_error(stored: Any) -> None:
    nbformat.validate(stored)
    for cell in code(stored):
        assert cell.outputs, cell.source
        for output in cell.outputs:
            assert output.output_type != "error"
            assert output.get("name") != "stderr"  # no warning either
    pictures = [
        o for cell in code(stored) for o in cell.outputs if "image/png" in o.get("data", {})
    ]
    assert len(pictures) >= 2


def test_nothing_in_it_depends_on_day_or_machine(stored: Any) -> None:
    text = json.dumps(stored)
    assert not re.search(r"/tmp/|/home/|/work/|20\d\d-\d\d-\d\d", text)
    assert set(stored.metadata) == {"kernelspec", "language_info"}
    assert all(not cell.metadata for cell in stored.cells)


def test_links_and_names_in_it_exist(stored: Any) -> None:
    prose = "\n".join(cell.source for cell in stored.cells if cell.cell_type == "markdown")
    for target in re.findall(r"\]\(([^)#]+)\)", prose):
        assert (WALKTHROUGH.parent / target).exists(), target
    for name in set(re.findall(r"\bbc\.(\w+)", "\n".join(c.source for c in code(stored)))):
        assert name in bc.__all__
