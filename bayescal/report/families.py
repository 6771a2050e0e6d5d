"""What a comparison across families prints, and one joint model in full."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from bayescal.comparison.families.results import FamilyComparison
from bayescal.report.family_tables import (
    correlation_table,
    elpd_words,
    listed,
    models_table,
    parameters_table,
)
from bayescal.report.family_words import (
    assumed_lines,
    fit_words,
    header_lines,
    models_notes,
    no_criteria,
    power_words,
    sampling_words,
    weak_lines,
)
from bayescal.report.render import indented, laid_out
from bayescal.rounding import significant

NOT_SOUND = "NOT SOUND: some draws did not converge; see the caveats."


def families_view(found: FamilyComparison) -> RenderableType:
    """Everything that ``compare --family`` prints."""
    rows = listed(found)
    parts: list[RenderableType] = [_header(found), laid_out(models_table(found, rows))]
    known = [m.criteria.bic for m in found.models if m.criteria.bic is not None]
    criteria = no_criteria(found)
    if known:
        criteria = f"dBIC above {min(known):.2f}, n counts points ({len(found.points)})."
    notes = [
        f"K counts what is inferred but tau; {criteria}",
        "elpd: leave-one-out, r and c of a point together; +- its standard error; d elpd against "
        "the best, with the paired one.",
    ]
    parts += [*indented([*notes, *models_notes(found, rows, "--json has them")]), _verdict(found)]
    told = next((m for m in found.models if m.posterior is not None or m.exact), None)
    if told is not None:
        parts += [Text(""), laid_out(parameters_table(told))]
    if any(m.posterior is not None for m in found.models):
        parts.append(_sampling(found))
    return Group(*parts)


def joint_fit_view(found: FamilyComparison) -> RenderableType:
    """Everything that ``fit --family`` prints: one model in full."""
    model, loo = found.best, found.best.loo
    parts: list[RenderableType] = [_header(found)]
    error = significant(model.log_evidence_error, 1)
    evidence = f"{model.log_evidence:.3f} " + ("(closed form)" if model.exact else f"+- {error}")
    known, criteria = model.criteria, no_criteria(found)
    if known.log_likelihood is not None:
        criteria = (
            f"ln L maximised {known.log_likelihood:.3f}, AIC {known.aic:.2f}, BIC {known.bic:.2f}"
        )
    facts = [
        f"{model.key}: K = {known.n_parameters}, {criteria}",
        f"ln evidence {evidence}"
        + ("" if loo is None else f"; elpd {elpd_words(loo)} +- {loo.se:.1f}"),
    ]
    facts += filter(None, [fit_words(model)])
    parts += [Text(line) for line in facts]
    parts += [Text(f"caveat: {c}.") for c in found.verdict.caveats]
    if model.posterior is not None:
        parts += [
            laid_out(parameters_table(model)),
            laid_out(correlation_table(model.posterior)),
            *map(Text, weak_lines(model.posterior)),
            _sampling(found),
        ]
    if model.exact:
        parts += [Text(""), laid_out(parameters_table(model)), *map(Text, power_words(model))]
    return Group(*parts)


def _header(found: FamilyComparison) -> RenderableType:
    lines = header_lines(found)
    for name, words in assumed_lines(found):
        lines.append(f"{name}{', ' if name == 'prior' else ': '}{words}")
    return Text("\n".join(lines) + "\n")


def _verdict(found: FamilyComparison) -> RenderableType:
    text = Text("Verdict across families: ", style="bold")
    text.append(found.verdict.text)
    caveats = indented(f"caveat: {c}." for c in found.verdict.caveats)
    return Group(Text(""), Padding(text, (0, 0, 0, 2)), *caveats)


def _sampling(found: FamilyComparison) -> RenderableType:
    text = sampling_words(found)
    if found.sound:
        return Text(text)
    return Text(f"{text}\n{NOT_SOUND}", style="bold")
