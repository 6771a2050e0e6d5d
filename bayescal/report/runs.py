"""Runs of every kind: written from a result, and read back as one, by what they hold."""

from __future__ import annotations

from pathlib import Path

from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.outliers.results import OutlierStudy
from bayescal.comparison.results import Comparison
from bayescal.errors import InputError
from bayescal.report.comparison_run import open_comparison, write_comparison
from bayescal.report.document import document
from bayescal.report.facts import dumps
from bayescal.report.families_document import SCHEMA as FAMILIES
from bayescal.report.families_document import families_document
from bayescal.report.families_run import open_families, write_families
from bayescal.report.outliers import SCHEMA as OUTLIERS
from bayescal.report.outliers import outliers_document
from bayescal.report.outliers_run import open_outliers, write_outliers
from bayescal.report.run_files import is_run, schema_of

Result = Comparison | FamilyComparison | OutlierStudy


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
    schema = schema_of(place) if is_run(place) else None
    if schema not in (FAMILIES, OUTLIERS):  # what is no run at all is refused there
        return open_comparison(place, defend=defend)
    if defend is not None:
        raise InputError(f"{place}: is no comparison of orders, which alone is defended")
    return open_families(place) if schema == FAMILIES else open_outliers(place)


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
    place, how = Path(folder), "bayescal.save_run"
    if isinstance(result, FamilyComparison):
        write_families(place, result, dumps(families_document(result, how)), force=force)
    elif isinstance(result, OutlierStudy):
        write_outliers(place, result, dumps(outliers_document(result, how)), force=force)
    else:
        write_comparison(place, result, dumps(document(result, how)), force=force)
