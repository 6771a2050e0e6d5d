"""Runs of every kind: written from a result, and read back as one, by what they hold."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # a kind is imported where it is asked for
    from bayescal.comparison.families.results import FamilyComparison
    from bayescal.comparison.lenses.results import LensComparison
    from bayescal.comparison.outliers.results import OutlierStudy
    from bayescal.comparison.results import Comparison
    from bayescal.report.run.kind import RunKind

    Result = Comparison | FamilyComparison | OutlierStudy | LensComparison

# A kind is one module in kinds/, with its KIND, and one name here. The first of them says what a
# folder of no kind lacks.
NAMES = ("comparison", "families", "outliers", "lenses")


def kinds() -> Iterator[RunKind[Any]]:
    """Give every kind of result that runs hold."""
    yield from map(kind_named, NAMES)


def kind_named(name: str) -> RunKind[Any]:
    """Find a kind by its name."""
    kind: RunKind[Any] = import_module(f"bayescal.report.kinds.{name}").KIND
    return kind


def kind_of(result: object) -> RunKind[Any]:
    """Find the kind of a result."""
    return next(kind for kind in kinds() if isinstance(result, kind.result))


def kind_at(folder: Path) -> RunKind[Any]:
    """Find the kind of what a run holds, by its document.

    Raises
    ------
    InputError
        Where the folder is no run.
    """
    from bayescal.report.run.files import document_at

    first = kind_named(NAMES[0])
    schema = document_at(folder, first.made_by).get("schema")
    return next((kind for kind in kinds() if kind.schema == schema), first)


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
    Comparison, FamilyComparison, OutlierStudy or LensComparison
        Whichever of `compare` or `fit`, `compare_families` or `fit_family`, `outliers`
        and `calibrate` the run is of.

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
    result : Comparison, FamilyComparison, OutlierStudy or LensComparison
        Of correspondences, or of views.
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
