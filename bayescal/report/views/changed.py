"""Whether two calibrations are of the same camera, as a table."""

from __future__ import annotations

import numpy as np

from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.changed import Change
from bayescal.report.blocks import Blocks, Listing, Prose, Tabled
from bayescal.report.table import Cell, Table, answers_table
from bayescal.report.views.maps import places_cells, remarks
from bayescal.report.views.prediction import models_words
from bayescal.rounding import rounded, significant


def changed_view(
    first: CalibratedCamera, second: CalibratedCamera, found: Change, names: tuple[str, str]
) -> Blocks:
    """Show the change at named places, and whether it is one.

    Parameters
    ----------
    names : tuple of str
        The runs or files that the cameras come from.
    """
    about = tuple(
        f"{which}: {name} (of {camera.source}), {models_words(camera)}"
        for which, name, camera in zip(("first", "second"), names, (first, second), strict=True)
    )
    return (
        Listing(about, "about"),
        Prose(found.verdict, lead="Change"),
        Tabled("change", "Second less first, px.", _table(found), tuple(_lines(found))),
    )


def _table(found: Change) -> Table:
    at = found.named
    assert at is not None, "of the whole image"
    heads = ("place", "r", "c", "change in r", "change in c", "size", "sd", "")
    known = ~np.isnan(at.sd)

    def cells(i: int) -> list[Cell] | None:
        if not known[i]:
            return None
        sd = float(at.sd[i])
        moved = (Cell(rounded(float(v), sd)) for v in (*at.shift[i], at.size[i]))
        return [*moved, Cell(significant(sd))]

    notes = remarks(at.places, known, "not seen by both")
    return answers_table(heads, places_cells(at.places), cells, notes)


def _lines(found: Change) -> list[str]:
    frame = (
        "Both stand in one world: a camera that was moved is a change too."
        if found.posed
        else "The turn between their frames is taken out: the poses of the views absorb it."
    )
    return [
        f"{frame} sd: of each of r and c of the change, both calibrations' uncertainty.",
        f"p: how often two calibrations of one camera would differ so much where both were "
        f"calibrated, by {_basis(found)}.",
        *_apart(found),
    ]


def _basis(found: Change) -> str:
    """Say what p is of."""
    model = " and ".join(dict.fromkeys(found.tested))
    if found.by_data:
        return f"what the points alone say of {model}, without the prior"
    return (
        f"the draws of both posteriors of {model}; what the prior says is in both, so that p is "
        "rather too large"
    )


def _apart(found: Change) -> list[str]:
    """Say where the calibrations share no model."""
    if found.tested[0] == found.tested[1]:
        return []
    return [
        "No model is plausible by both calibrations: what these two models differ by counts as a "
        "change."
    ]
