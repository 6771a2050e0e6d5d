"""Is it the order, or is it the model: families of models of r and c together."""

from __future__ import annotations

from bayescal.comparison.families.results import FamilyComparison, JointModel
from bayescal.comparison.verdict import percent
from bayescal.errors import InputError
from bayescal.report.family_tables import listed, models_table, parameters_table
from bayescal.report.family_words import (
    assumed_lines,
    models_notes,
    power_words,
    sampling_words,
    weak_lines,
)
from bayescal.report.figures.registry import FAMILY_KINDS
from bayescal.report.page.blocks import (
    Answer,
    Answers,
    Block,
    Details,
    Facts,
    Listing,
    Part,
    Prose,
    Section,
    Tabled,
)
from bayescal.report.page.subject import PageSubject, pictured

CAPTIONS = {
    "models": "Log evidence of every model less the highest, one scale for all. Dark cells are "
    "probable, the most probable model is framed; bold: not excluded at 95%.",
    "vectors": "Residuals over the image, from predicted to measured, of the best model and of the "
    "best under the other treatment of the camera position; lengths magnified alike.",
    "position": "Posterior of the camera position by the best model of each family at a free "
    "position; above each panel, mean ± sd of the most probable of them and the prior.",
    "correlation": "Correlations of the parameters of the most probable model that was sampled.",
}
MEANINGS = (
    "Angles (rotation) in degrees, a rotation vector about the stated orientation; position of "
    "the camera in world units; focal lengths, principal point (centre), sigma and polynomial "
    "coefficients in px; k: radial coefficients, without unit; tau: strength of the "
    "non-linearity as a fraction of the image. Intervals are central, 95%."
)


def section(subject: PageSubject) -> Section | None:
    """Show the families where they were compared."""
    return None if subject.families is None else families_section(subject.families)


def families_section(found: FamilyComparison) -> Section:
    """Show the verdict across families, its numbers, and the best models' parameters.

    Parameters
    ----------
    found : FamilyComparison
    """
    rows = listed(found)
    blocks: list[Block] = [*_verdict(found), _picture(found, "models")]
    said = [*models_notes(found, rows, "folded away below"), *found.notes]
    notes = tuple(map(_sentence, said))
    words = "Models of r and c together, the most probable first."
    blocks.append(Tabled("families-models", words, models_table(found, rows), notes))
    if len(rows) < len(found.models):
        every = models_table(found, range(len(found.models)))
        table = Tabled("families-all", "Every model compared.", every)
        blocks.append(Details("Every model compared", (table,)))
    x, y, z = found.points.setup.position
    camera = ("camera", f"stated at ({x:g}, {y:g}, {z:g}), world units")
    blocks.append(Part("What was assumed", (Facts((camera, *assumed_lines(found))),)))
    blocks.append(Part("What is left over, over the image", (_picture(found, "vectors"),)))
    blocks += [Part(f"Parameters of {m.key}", _parameters(m)) for m in _shown(found)]
    sampled = _picture(found, "position"), _picture(found, "correlation")
    blocks.append(Part("Camera position, and what moves together", (*sampled, *_weak(found))))
    return Section(
        "families",
        "Families of models",
        "Is it the order, or is it the model? The same pixels by other families, and with the "
        "camera position inferred.",
        tuple(blocks),
    )


def _verdict(found: FamilyComparison) -> list[Block]:
    """Say in large type what was found, then in words."""
    best, verdict = found.best.key, found.verdict
    standing = f"{percent(found.probabilities[0])} probable"
    others = len(verdict.plausible) - 1
    if len(found.models) == 1:
        standing = "the only one compared"
    elif verdict.decided:
        standing += "; decided at 95%"
    else:
        standing += f"; {others} other{'s' * (others > 1)} not excluded"
    order = f"({best.order})" if len(best.orders) > 1 else best.order
    answers = [Answer("model of r and c", f"{best.family} {order}", standing)]
    x, y, z = found.best.position
    where = f"at ({x:.4g}, {y:.4g}, {z:.4g}) it fits best"
    if len(verdict.positions) > 1:
        where += f"; {percent(verdict.positions[best.position])} over all models"
    answers.append(Answer("camera position", best.position, where))
    blocks: list[Block] = [
        Answers(tuple(answers)),
        Prose(verdict.text),
    ]
    if verdict.caveats:
        blocks.append(Listing(tuple(f"Caveat: {c}." for c in verdict.caveats), "caveat"))
    return blocks


def _shown(found: FamilyComparison) -> list[JointModel]:
    """Give the most probable model whose parameters are known, and the first that was sampled."""
    known = [m for m in found.models if m.posterior is not None or m.exact][:1]
    sampled = [m for m in found.models if m.posterior is not None][:1]
    return known if sampled == known else [*known, *sampled]


def _parameters(model: JointModel) -> tuple[Block, ...]:
    how = "in closed form" if model.posterior is None else "from draws of emcee"
    return (
        Tabled(
            f"families-{model.key.file(model.key.noise)}",
            f"Posterior of the parameters of {model.key}, {how}.",
            parameters_table(model),
            (MEANINGS, *map(_sentence, power_words(model))),
        ),
    )


def _weak(found: FamilyComparison) -> tuple[Block, ...]:
    """Name combinations that the data hardly tell apart, and say how the sampling went."""
    blocks: list[Block] = []
    for model in found.models:
        if model.posterior is not None:
            lines = tuple(map(_sentence, weak_lines(model.posterior)))
            none = f"No combination of parameters of {model.key} is weakly identified."
            blocks.append(Listing(lines or (none,)))
            break
    words = sampling_words(found)
    return (*blocks, Prose(words, "note")) if words else tuple(blocks)


def _sentence(line: str) -> str:
    return f"{line[0].upper()}{line[1:].rstrip('.')}."


def _picture(found: FamilyComparison, kind: str) -> Block:
    """Draw a figure, or say why there is none."""
    shown = FAMILY_KINDS[kind]
    try:
        figure, alt = shown.draw(found), shown.alt_text(found)
    except InputError as error:
        return Prose(f"No figure of {shown.summary.removeprefix('families: ')}: {error}.", "note")
    return pictured(f"figure-families-{kind}", figure, alt, CAPTIONS[kind])
