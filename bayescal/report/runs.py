"""Runs of every kind: written from a result, and read back as one, by what they hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.results import Comparison
from bayescal.report.kinds.comparison import COMPARISON
from bayescal.report.kinds.families import FAMILIES
from bayescal.report.kinds.outliers import OUTLIERS
from bayescal.report.run.files import document_at
from bayescal.report.run.kind import RunKind

# A kind is one module in kinds/ and one line here.
KINDS: tuple[RunKind[Any], ...] = (
    COMPARISON,  # first: of a folder of no kind it says what is missing
    FAMILIES,
    OUTLIERS,
)
Result = Comparison | FamilyComparison | OutlierStudy


def kind_of(result: object) -> RunKind[Any]:
    """Find the kind of a result."""
    return next(kind for kind in KINDS if isinstance(result, kind.result))


def kind_at(folder: Path) -> RunKind[Any]:
    """Find the kind of what a run holds, by its document.

    Raises
    ------
    InputError
        Where the folder is no run.
    """
    schema = document_at(folder, KINDS[0].made_by).get("schema")
    return next((kind for kind in KINDS if kind.schema == schema), KINDS[0])


def open_run(folder: str | Path, *, defend: bool | None = None) -> Result:
    """Read a result back from the folder that ``--out`` or `save_run` wrote.

    Nothing is sampled: the draws are read. What follows from points and draws is computed
    again and compared with what the run says.

    Parameters
    ----------
    folder : str or Path
    defend : bool, optional
        Of a comparison of orders, whether to answer a referee's questions too; by default
        where the run does.

    Returns
    -------
    Comparison, FamilyComparison or OutlierStudy
        Whichever of `compare` or `fit`, `compare_families` or `fit_family`, and
        `outliers` the run is of.

    Raises
    ------
    InputError
        Where the folder is no run, was written by a version whose runs this one can't
        read, is incomplete, was changed, or says other numbers than computed now.
    """
    place = Path(folder)
    found: Result = kind_at(place).open(place, defend=defend)
    return found


def save_run(result: Result, folder: str | Path, *, force: bool = False) -> None:
    """Write a result to a folder that `open_run` reads back.

    Parameters
    ----------
    result : Comparison, FamilyComparison or OutlierStudy
        Of correspondences.
    folder : str or Path
        Where to; an earlier run is left alone unless `force`.
    force : bool, optional

    Raises
    ------
    InputError
        Where the comparison is of plain arrays.
    OutputError
        Where the run can't be written; nothing is left behind.
    """
    kind = kind_of(result)
    kind.write(Path(folder), result, kind.text(result, "bayescal.save_run"), force=force)
