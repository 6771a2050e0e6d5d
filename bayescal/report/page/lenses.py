"""A comparison of lens models as a page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bayescal.comparison.lenses.results import LensComparison
from bayescal.files import write_whole
from bayescal.report.blocks import Block, Facts, Prose, Section, Tabled, listed
from bayescal.report.document.lenses import lenses_document
from bayescal.report.figures import lenses as figures
from bayescal.report.page.page import Page, html
from bayescal.report.page.pictures import pictured
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.report.views import provenance
from bayescal.report.views.lenses import (
    UNSOUND,
    about,
    assumed,
    lens_footnotes,
    lenses_table,
    parameters_note,
    parameters_table,
    places_note,
    places_table,
    sampling_words,
)
from bayescal.version import __version__


def lenses_page(found: LensComparison, command: str) -> Page:
    """Collect everything that the page shows.

    Parameters
    ----------
    found : LensComparison
    command : str
        How it was asked for, for the provenance.
    """
    kept = lenses_document(found, command)
    sections = (
        _verdict(found),
        _lenses(found),
        _left_over(found),
        _sure(found),
        _parameters(found),
        provenance.section({"lenses": kept}),
    )
    return Page(
        title="Which lens model? Many views of a target compared",
        about=tuple(about(found)),
        warning="" if found.sound else f"Not sound: {UNSOUND}",
        sections=sections,
        made_by=f"bayescal {__version__}, {kept['provenance']['created']}",
    )


def save_lens_report(
    found: LensComparison, path: str | Path, command: str, *, force: bool = False
) -> None:
    """Write the page.

    Raises
    ------
    OutputError
        Where the file exists (without `force`) or can't be written.
    """
    made = html(lenses_page(found, command))
    write_whole(Path(path), made.encode(), force=force)


def _verdict(found: LensComparison) -> Section:
    verdict = found.verdict
    blocks: list[Block] = [
        Prose(verdict.text),
        *listed([f"{caveat}." for caveat in verdict.caveats], "caveat"),
        Facts(tuple(assumed(found))),
        Prose(sampling_words(found)),
    ]
    return Section("verdict", "Verdict", "Which lens these views support.", tuple(blocks))


def _lenses(found: LensComparison) -> Section:
    picture = pictured(
        "figure-evidence",
        figures.draw_evidence(found),
        figures.evidence_text(found),
        "Log evidence of each lens below the best; dark: not excluded at 95%.",
    )
    table = Tabled(
        "lenses",
        "Lens models, the most probable first.",
        lenses_table(found),
        tuple(lens_footnotes(found)),
    )
    return Section(
        "lenses", "Lens models", "The same views, the poses integrated out.", (table, picture)
    )


def _left_over(found: LensComparison) -> Section:
    picture = pictured(
        "figure-vectors",
        figures.draw_vectors(found),
        figures.vectors_text(found),
        "What is left over of every point in all views, the target's offsets taken out; lengths "
        "magnified.",
    )
    table = Tabled("views", "Residuals of each view, px.", _views_table(found))
    return Section(
        "residuals",
        "What is left over",
        "A pattern in the image is a lens that the model lacks.",
        (picture, table),
    )


def _views_table(found: LensComparison) -> Table:
    data, lost = found.setting.data, found.best.left_out
    squares = (found.best.evidence.problem.noise**2).sum(axis=(1, 2))
    columns = (
        Column("view"), Column("points"), Column("rms", "of the residuals, px"),
        Column("elpd", "of the view from the others, nat"),
    )  # fmt: skip
    rows = []
    for v, name in enumerate(found.views.names):
        own = None if lost is None else float(lost.log_density[v])
        spread = float(np.sqrt(squares[v] / data.counts[v]))
        rows.append(
            (
                Cell(name),
                number_cell(int(data.counts[v]), lambda n: f"{n:.0f}"),
                number_cell(spread, lambda x: f"{x:.3f}"),
                number_cell(own, lambda x: f"{x:.1f}"),
            )
        )
    return Table(columns, tuple(rows))


def _sure(found: LensComparison) -> Section:
    picture = pictured(
        "figure-uncertainty",
        figures.draw_uncertainty(found),
        figures.uncertainty_text(found),
        "Standard deviation of the projection at infinity, px (rms of r and c), the turn of the "
        "poses taken out; dots: the points.",
    )
    places = Tabled(
        "places", "Uncertainty at places, px.", places_table(found), (places_note(found),)
    )
    return Section(
        "uncertainty",
        "How sure the lens is",
        "Where the camera can be trusted.",
        (places, picture),
    )


def _parameters(found: LensComparison) -> Section:
    table = Tabled(
        "parameters",
        f"Posterior of {found.best.key}.",
        parameters_table(found),
        (parameters_note(found),),
    )
    return Section("parameters", "Parameters", "What emcee's draws say.", (table,))
