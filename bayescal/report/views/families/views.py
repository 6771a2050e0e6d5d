"""A comparison across families as people see it: what is printed, and the chapter of a page."""

from __future__ import annotations

from bayescal.comparison.criteria.information import ACROSS
from bayescal.comparison.families.defence import LEFT_OUT
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.prediction.calibrated.families import families_camera
from bayescal.report.blocks import (
    Answer,
    Answers,
    Block,
    Blocks,
    Details,
    Facts,
    Figure,
    Listing,
    Part,
    Prose,
    Section,
    Tabled,
    listed,
)
from bayescal.report.views.covariance import covariance_tabled
from bayescal.report.views.families.tables import (
    correlation_table,
    elpd_words,
    models_table,
    parameters_table,
    shortlist,
)
from bayescal.report.views.families.words import (
    about,
    assumed_lines,
    fit_words,
    grouped_words,
    methods_words,
    models_notes,
    no_criteria,
    power_words,
    sampling_words,
    weak_words,
)
from bayescal.report.views.maps import map_section
from bayescal.report.views.orders.adequacy import adequacy_blocks
from bayescal.report.views.remember import remembered
from bayescal.report.views.views import Views
from bayescal.report.views.words import distrust, doubts, verdict_blocks
from bayescal.rounding import percent, significant

UNSOUND = "some draws did not converge, or an evidence should not be trusted; see the caveats."
CAPTIONS = {
    "models": "Log evidence of every model less the highest, one scale for all. The fuller the "
    "colour, the more probable; the most probable model is framed; bold: not excluded at 95%.",
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


def brief(found: FamilyComparison) -> Blocks:
    """Everything that ``compare --family`` prints."""
    told = _shown(found)[:1]
    return (
        *_header(found),
        models(found, "--json has them"),
        *verdict(found),
        *(Part("  Adequacy", adequacy(found)) for _ in found.adequacy[:1] if found.defence),
        *(parameters(model, found) for model in told),
        *more_words(found),
        *sampling(found),
        *((remembered({"": found.verdict}),) if found.defence else ()),
    )


def full(found: FamilyComparison) -> Blocks:
    """Everything that ``fit --family`` prints: one model in full."""
    model = found.best
    lines = [*_numbers(model, found), *filter(None, [fit_words(model)])]
    blocks: list[Block] = [*_header(found), Listing(tuple(lines)), *verdict(found)]
    if model.posterior is not None or model.exact:
        blocks.append(parameters(model, found))
    if model.posterior is not None:
        table = correlation_table(model.posterior)
        notes = tuple(weak_words(model.posterior))
        blocks.append(Tabled("families-correlation", "Correlations.", table, notes))
    return (*blocks, *sampling(found))


def section(found: FamilyComparison) -> Section:
    """Show the verdict across families, its numbers, and what they assume."""
    blocks: list[Block] = [Answers(_answers(found)), *verdict(found)]
    if len(found.models) > 1:
        blocks.append(_figure(found, "models"))
    blocks.append(models(found, "folded away below"))
    first = set(shortlist(found))
    rest = [i for i in range(len(found.models)) if i not in first]
    if rest:
        title = "The other models compared"
        table = Tabled("families-rest", f"{title}.", models_table(found, rest))
        blocks.append(Details(title, (table,)))
    blocks.append(Part("What was assumed", (Facts(_assumed(found)),)))
    return Section(
        "other-models",
        "Families of models",
        "Is it the order, or is it the model? The same pixels by other families, and with the "
        "camera position inferred.",
        tuple(blocks),
    )


def residuals_section(found: FamilyComparison) -> Section:
    """Show what the best models leave over."""
    lead = "Noise has no pattern over the image; what has one is a shape that the model lacks."
    blocks = (_figure(found, "vectors"), *adequacy(found))
    return Section("families-residuals", "Residuals of families", lead, blocks)


def parameters_section(found: FamilyComparison) -> Section:
    """Show the parameters of the best models, and of what else is plausible."""
    shown = _shown(found)
    blocks: list[Block] = [Part(f"Parameters of {m.key}", _parameters(m, found)) for m in shown]
    plausible = found.verdict.plausible
    rest = [m for m in found.models if m not in shown]
    rest = [m for m in rest if m.posterior is not None or m.key in plausible]
    blocks += [Details(f"Parameters of {m.key}", _parameters(m, found, folded=True)) for m in rest]
    figures = _figure(found, "position"), _figure(found, "correlation")
    together = (*figures, *_weak(found), *sampling(found))
    blocks.append(Part("Camera position, and what moves together", together))
    lead = "Where the camera is, and what its optics are, by the most probable models."
    return Section("families-parameters", "Parameters of families", lead, tuple(blocks))


def headlines(found: FamilyComparison) -> list[str]:
    """Give the verdict."""
    return [found.verdict.text]


def title(found: FamilyComparison) -> str:
    """Head a page."""
    if len(found.models) == 1:
        return "A camera model in full"
    return "The order, or the model? Families of camera models compared"


VIEWS = Views(
    title,
    about,
    brief,
    full,
    headlines,
    {
        "families": section,
        "residuals of families": residuals_section,
        "parameters of families": parameters_section,
        "maps": lambda found: map_section(found, families_camera),
    },
    UNSOUND,
    beside=methods_words,
)


def _header(found: FamilyComparison) -> Blocks:
    return (*listed(about(found), "about"), Facts(tuple(assumed_lines(found))))


def _assumed(found: FamilyComparison) -> tuple[tuple[str, str], ...]:
    x, y, z = found.points.setup.position
    camera = ("camera", f"stated at ({x:g}, {y:g}, {z:g}), world units")
    return (camera, *assumed_lines(found))


def models(found: FamilyComparison, rest: str) -> Tabled:
    """Show the most probable models; `rest` says where the others are."""
    rows = shortlist(found)
    known = [m.criteria.bic for m in found.models if m.criteria.bic is not None]
    criteria = no_criteria(found)
    if known:
        criteria = f"dBIC above {min(known):.2f}, n counts points ({found.points.n})."
    legend = (
        f"K counts what is inferred but tau; {criteria}",
        "elpd: leave-one-out, r and c of a point together; ± its standard error; d elpd against "
        "the best, with the paired one.",
    )
    caption = "Joint models of r and c, the most probable first."
    notes = tuple(models_notes(found, rows, rest))
    return Tabled("families-models", caption, models_table(found, rows), notes, legend)


def verdict(found: FamilyComparison) -> Blocks:
    """Say in words what was found, with its caveats."""
    lead = "Verdict across families" if len(found.models) > 1 else "Verdict"
    return verdict_blocks(found.verdict, lead)


def adequacy(found: FamilyComparison) -> Blocks:
    """Show the tests of the most probable model's residuals, and what was not done."""
    left = () if found.defence is None else (Prose(LEFT_OUT, "note"),)
    return (*adequacy_blocks(found.adequacy, "families", str(found.best.key)), *left)


def more_words(found: FamilyComparison) -> Blocks:
    """Say what a defence would add."""
    if found.defence is not None or found.settings.choice.robust or len(found.models) < 2:
        return ()
    more = "every test of adequacy, and which points and groups the choice rests on"
    return (Prose(f"Would it persuade a referee? --defend adds {more}."),)


def parameters(model: JointModel, found: FamilyComparison) -> Tabled:
    """Show the posterior of a model's parameters, and their spread over groups if it is known."""
    how = "from draws of emcee" if model.posterior is not None else "from weighted draws"
    how = "in closed form" if model.exact else how
    caption = f"Posterior of the parameters of {model.key}, {how}."
    grouped = found.grouped if model is found.best else None
    notes = (*power_words(model), *grouped_words(grouped), MEANINGS)
    id = f"families-{model.key.file(model.key.noise)}"
    return Tabled(id, caption, parameters_table(model, grouped), notes)


def _parameters(model: JointModel, found: FamilyComparison, *, folded: bool = False) -> Blocks:
    """Show a model's parameters, and how they move together."""
    id = f"families-covariance-{model.key.file(model.key.noise)}"
    together = covariance_tabled(id, str(model.key), *model.named_covariance())
    if not folded:
        return parameters(model, found), Details("Covariance and correlations", (together,))
    return parameters(model, found), together


def sampling(found: FamilyComparison) -> Blocks:
    """Say how the sampling of all models went; nothing where none was sampled."""
    words = sampling_words(found)
    said = (Prose(words, lead="Sampling"),) if words else ()
    return (*said, *distrust(UNSOUND, sound=found.sound))


def _numbers(model: JointModel, found: FamilyComparison) -> tuple[str, str]:
    """Give what is one number about a model."""
    error = significant(model.log_evidence_error, 1)
    evidence = f"{model.log_evidence:.3f} " + ("(closed form)" if model.exact else f"± {error}")
    known, criteria = model.criteria, no_criteria(found)
    if known.log_likelihood is not None:
        values = [f"{c.name} {v:.2f}" for c in ACROSS if (v := known.values.get(c.key)) is not None]
        criteria = ", ".join((f"ln L maximised {known.log_likelihood:.3f}", *values))
    loo = "" if model.loo is None else f"; elpd {elpd_words(model.loo)} ± {model.loo.se:.1f}"
    return f"{model.key}: K = {known.n_parameters}, {criteria}", f"ln evidence {evidence}{loo}"


def _answers(found: FamilyComparison) -> tuple[Answer, Answer]:
    """Say in large type what was found."""
    best, verdict = found.best.key, found.verdict
    order = f"({best.order})" if len(best.orders) > 1 else best.order
    x, y, z = found.best.position
    where = f"at ({x:.4g}, {y:.4g}, {z:.4g}) world units it fits best"
    if len(verdict.positions) > 1:
        where += f"; {percent(verdict.positions[best.position])} over all models"
    return (
        Answer(
            "model of r and c",
            f"{best.family} {order}",
            verdict.standing,
            doubts(verdict),
        ),
        Answer("camera position", best.position, where),
    )


def _shown(found: FamilyComparison) -> list[JointModel]:
    """Give the most probable model whose parameters are known, and the first that was sampled."""
    known = [m for m in found.models if m.posterior is not None or m.exact][:1]
    sampled = [m for m in found.models if m.posterior is not None][:1]
    return known if sampled == known else [*known, *sampled]


def _weak(found: FamilyComparison) -> Blocks:
    """Name combinations that the data hardly tell apart, of the first model that was sampled."""
    for model in found.models:
        if model.posterior is not None:
            none = f"No combination of parameters of {model.key} is weakly identified."
            return listed(weak_words(model.posterior) or [none])
    return ()


def _figure(found: FamilyComparison, name: str) -> Figure:
    return Figure(name, found, CAPTIONS[name])
