"""Executes a notebook with the code of this checkout; as a program, renews its outputs in place."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell

WALKTHROUGH = Path(__file__).resolve().parents[2] / "docs" / "walkthrough.ipynb"
# What warns is wrong; ArviZ 0.23 announces its successor at import (Python 3.11 only).
STRICT = """
import warnings
warnings.simplefilter("error")
warnings.filterwarnings("ignore", r"\\s*ArviZ is undergoing a major refactor", FutureWarning)
"""


def executed(notebook: Any, folder: Path) -> Any:
    """Run every cell in a fresh kernel of this interpreter; a warning or error in one is raised."""
    copy = nbformat.from_dict(notebook)
    lenient = 'warnings.simplefilter("default")'  # what ends the kernel is not ours
    copy.cells = [new_code_cell(STRICT), *copy.cells, new_code_cell(lenient)]
    client = NotebookClient(
        copy,
        timeout=300,
        kernel_name="python3",
        record_timing=False,
        resources={"metadata": {"path": str(folder)}},
    )
    client.execute()
    copy.cells = copy.cells[1:-1]
    return cleaned(copy)


def cleaned(notebook: Any) -> Any:
    """Take out whatever another machine or day would change."""
    notebook.metadata = nbformat.from_dict(
        {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        }
    )
    code = (cell for cell in notebook.cells if cell.cell_type == "code")
    for count, cell in enumerate(code, 1):
        cell.metadata = nbformat.from_dict({})
        cell.execution_count = count
        for output in cell.outputs:
            if "execution_count" in output:
                output.execution_count = count
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
    return notebook


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as place:
        path = Path(sys.argv[1]) if len(sys.argv) > 1 else WALKTHROUGH
        nbformat.write(executed(nbformat.read(path, as_version=4), Path(place)), path)
