"""Lens models over many views as people see them: what is printed, and the chapters of a page."""

from __future__ import annotations

from dataclasses import replace

from bayescal.comparison.faces.convert import Converts
from bayescal.comparison.lenses.results import LensComparison
from bayescal.prediction.calibrated.lenses import lens_camera
from bayescal.report.blocks import (
    Answer,
    Answers,
    Block,
    Blocks,
    Details,
    Facts,
    Figure,
    Part,
    Prose,
    Section,
    Tabled,
    listed,
)
from bayescal.report.views.covariance import covariance_tabled
from bayescal.report.views.lenses.tables import (
    SHOWN,
    bad_table,
    gross_table,
    lenses_table,
    parameters_table,
    places_table,
    views_table,
)
from bayescal.report.views.lenses.words import (
    about,
    assumed,
    bow_words,
    columns_words,
    error_words,
    impossible_words,
    not_shown_words,
    parameters_note,
    places_note,
    sampling_words,
    weak_words,
)
from bayescal.report.views.maps import map_section
from bayescal.report.views.views import Views
from bayescal.report.views.words import distrust, doubts, verdict_blocks
from bayescal.rounding import counted, significant

UNSOUND = "draws did not converge, or an evidence should not be trusted."
SHOWN_BAD = 20  # points in print
CAPTIONS = {
    "evidence": "Log evidence over the number of radial coefficients, below the best lens; "
    "dashed: odds of 20 to 1. On the right lenses that have one order alone.",
    "models": "Log evidence of each lens below the best; strong colour: not excluded at 95%.",
    "vectors": "What is left over of every point in all views, the target's offsets taken out; "
    "lengths magnified.",
    "views": "The same, view by view; one scale for all.",
    "corner": "Posterior of the lens, its error models averaged: every pair of parameters, and "
    "each alone.",
    "bow": "Where points of the target are off, from its residuals in all views, and its bow.",
}


def brief(found: LensComparison) -> Blocks:
    """Everything that ``calibrate`` prints."""
    return (
        *listed(about(found), "about"),
        Facts(tuple(assumed(found))),
        lenses(found, *not_shown_words(found)),
        *verdict_blocks(found.verdict, "Verdict"),
        *bad(found, SHOWN_BAD),
        *gross(found),
        parameters(found),
        places(found),
        *sampling(found),
    )


def lenses(found: LensComparison, *notes: str) -> Tabled:
    """Show the most probable lenses, with notes beside the table's own."""
    caption = "Lens models, the most probable first."
    shown = lenses_table(found, found.lenses[:SHOWN])
    notes = (*impossible_words(found), *notes)
    return Tabled("lenses", caption, shown, notes, columns_words())


def parameters(found: LensComparison) -> Tabled:
    """Show the posterior of the best lens."""
    notes = (parameters_note(found), *weak_words(found))
    caption = f"Posterior of {found.best.name}."
    return Tabled("lens-parameters", caption, parameters_table(found), notes)


def bad(found: LensComparison, most: int | None = None) -> Blocks:
    """Show the points that are taken for bad, or may be, where there are any."""
    if found.bad is None or not found.bad.points:
        return ()
    points = found.bad.points
    most = len(points) if most is None else most
    notes = [
        "r, c: observed less where the good points put them, px; bad: probability, the lenses "
        "averaged. Residuals, RMS, dBIC, elpd and draws are without those that are rather bad; ln "
        "Z is of all points, summed over which are bad."
    ]
    if len(points) > most:
        notes.append(f"{len(points) - most} more, less probable or nearer: --json has them.")
    caption = "Points that are bad, or may be."
    folded = f"{counted(most, 'point')} that may be bad" if most > SHOWN_BAD else ""
    table = bad_table(found, most)
    return (Tabled("bad-points", caption, table, tuple(notes), folded=folded),)


def gross(found: LensComparison) -> Blocks:
    """Show the points that the error model can't explain, where there are any."""
    if not found.gross:
        return ()
    note = (
        "further off than the errors allow: r, c observed less where all the other points put "
        "them, px, each without those above it; p times the number of points."
    )
    return (Tabled("gross-errors", "Points to look at.", gross_table(found), (note,)),)


def places(found: LensComparison) -> Tabled:
    """Show how sure the projection is."""
    caption = "How sure the projection is, px."
    return Tabled("lens-places", caption, places_table(found), (places_note(found),))


def sampling(found: LensComparison) -> Blocks:
    """Say how the draws were made, and whether they can be trusted."""
    said = Prose(sampling_words(found), lead="Sampling")
    return said, *distrust(UNSOUND, sound=found.sound)


def verdict_section(found: LensComparison) -> Section:
    """Open the page: which lens, how sure, with which caveats."""
    told = verdict_blocks(found.verdict, "Verdict")
    blocks = (Answers(_answers(found)), *told, Facts(tuple(assumed(found))))
    return Section("verdict", "Verdict", "Which lens do these views support?", blocks)


def lenses_section(found: LensComparison) -> Section:
    """Show the evidence and what the choice is worth."""
    blocks: list[Block] = [lenses(found)]
    if len(found) > 1:
        blocks = [_figure(found, "evidence"), *blocks, _figure(found, "models")]
    if len(found) > SHOWN:
        rest = lenses_table(found, found.lenses[SHOWN:])
        title = "The other lenses compared"
        blocks.append(Details(title, (Tabled("lenses-rest", f"{title}.", rest),)))
    lead = "The same views by each lens, the poses integrated out."
    return Section("lenses", "Lens models", lead, tuple(blocks))


def image_section(found: LensComparison) -> Section:
    """Show where in the image the lens can be trusted, and what another one would move."""
    section = map_section(found, lens_camera)
    if section is None:
        lead = "How sure the projection is."
        return Section("maps", "Over the image", lead, (places(found),))
    return replace(section, blocks=(*section.blocks, places(found)))


def parameters_section(found: LensComparison) -> Section:
    """Show the posterior."""
    together = [_together(found, found.best.name, "lens")]
    together += [_together(j, j.name, j.key.file()) for j in found.lenses[1:]]
    folded = Details("Covariance and correlations of every lens", tuple(together))
    blocks = (parameters(found), folded, _figure(found, "corner"), *sampling(found))
    return Section("parameters", "Parameters", "What the draws say of the best lens.", blocks)


def residuals_section(found: LensComparison) -> Section:
    """Show what is left over, in the image and view by view."""
    table = Tabled("views", "Residuals of each view.", views_table(found))
    by_view = Part("View by view", (_figure(found, "views"), table))
    blocks = (_figure(found, "vectors"), *bad(found), *gross(found), by_view)
    lead = "A pattern in the image is a shape that the lens lacks."
    return Section("residuals", "What is left over", lead, blocks)


def target_section(found: LensComparison) -> Section | None:
    """Show what is wrong with the target; None where it is taken as exact."""
    if not (found.setting.bow or found.setting.grid.offsets):
        return None
    bow = bow_words(found)
    said = [words for words in (error_words(found), bow and f"bow {bow}") if words]
    blocks = (*listed([f"{words[0].upper()}{words[1:]}." for words in said]), _figure(found, "bow"))
    return Section("target", "The target", "How far is it from what it should be?", blocks)


VIEWS = Views(
    lambda _: "Which lens? Many views of a target compared",
    about,
    brief,
    brief,
    lambda found: [found.verdict.text],
    {
        "verdict": verdict_section,
        "lenses": lenses_section,
        "maps": image_section,
        "parameters": parameters_section,
        "residuals": residuals_section,
        "target": target_section,
    },
    UNSOUND,
)


def _answers(found: LensComparison) -> tuple[Answer, ...]:
    """Say in large type which lens, and how sure its projection is."""
    verdict = found.verdict
    answers = [Answer("lens", verdict.recommended, verdict.standing, doubts(verdict))]
    known = {place.name: place.infinity for place in found.places}
    corners = [v for name, v in known.items() if name.endswith("corner") and v is not None]
    if known["centre"] is not None and corners:
        centre, corner = (significant(v, 2) for v in (known["centre"], max(corners)))
        answers.append(
            Answer("sd of the projection", f"{centre} px", f"centre; corners {corner} px")
        )
    return tuple(answers)


def _together(found: Converts, name: str, id: str) -> Tabled:
    """Show how the parameters of a lens move together."""
    return covariance_tabled(f"covariance-{id}", name, *found.named_covariance())


def _figure(found: LensComparison, name: str) -> Figure:
    crosses = " Crosses: points taken for bad."
    crossed = name in ("vectors", "views") and found.bad is not None and found.bad.left_out
    return Figure(name, found, CAPTIONS[name] + (crosses if crossed else ""))
