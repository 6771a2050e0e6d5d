"""What a comparison across families prints, and one joint model in full."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from bayescal.comparison.families import FamilyComparison, JointModel
from bayescal.comparison.verdict import percent
from bayescal.comparison.weak import correlation, weak_combinations
from bayescal.inference.posterior import INTERVAL_PROBABILITY, ParameterSummary
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.models import bivariate
from bayescal.points.setup import AXES
from bayescal.report.grid import Cell, Column, Table
from bayescal.report.render import laid_out
from bayescal.rounding import rounded, significant

LISTED = 12  # the most probable, and the best of every family and position
UNITS = {
    "focal": "px",
    "centre": "px",
    "rotation": "deg",
    "position": "world",
    "sigma": "px",
    "alpha": "px",
    "beta": "px",
    "tau": "of image",
}


def families_view(found: FamilyComparison) -> RenderableType:
    """Everything that ``compare --family`` prints."""
    rows = _listed(found)
    left = len(found.models) - len(rows)
    parts: list[RenderableType] = [_header(found), models_table(found, rows)]
    best = min(m.bic for m in found.models)
    notes = [
        f"K counts coefficients, inferred sigmas and a free position; dBIC above {best:.2f}, n "
        f"counts points ({len(found.points)}).",
        "elpd: leave-one-out, r and c of a point together; +- its standard error; d elpd against "
        "the best, with the paired one.",
    ]
    if any(found.models[i].warnings or not found.models[i].sound for i in rows):
        notes.append("! marks an evidence that should not be trusted; --json says why.")
    if not all(found.models[i].elpd_reliable for i in rows):
        notes.append(
            "? marks an elpd whose importance weights have too heavy a tail (Pareto k not below "
            "0.7, or 0.64 of 600 draws): neither it nor its differences should be trusted."
        )
    if left:
        notes.append(f"{left} less probable models are not shown (--json has them).")
    parts += [Padding(Text(line), (0, 0, 0, 2)) for line in (*notes, *found.notes)]
    parts.append(_verdict(found))
    sampled = [m for m in found.models if m.posterior is not None]
    if sampled:
        best_sampled = next((m for m in found.models if m.posterior is not None), None)
        assert best_sampled is not None, "there is one"
        parts += [Text(""), *_parameters(best_sampled), _sampling(found)]
    return Group(*parts)


def joint_fit_view(found: FamilyComparison) -> RenderableType:
    """Everything that ``fit --family`` prints: one model in full."""
    model = found.best
    parts: list[RenderableType] = [_header(found)]
    error = significant(model.log_evidence_error, 1)
    evidence = f"{model.log_evidence:.3f} " + ("(closed form)" if model.exact else f"+- {error}")
    facts = [
        f"{model.name}: K = {model.n_parameters}, ln L maximised {model.log_likelihood:.3f}, "
        f"AIC {model.aic:.2f}, BIC {model.bic:.2f}",
        f"ln evidence {evidence}"
        + ("" if model.elpd is None else f"; elpd {model.elpd:.1f} +- {model.elpd_se:.1f}"),
    ]
    parts += [Text(line) for line in facts]
    parts += [Text(f"caveat: {c}.") for c in found.verdict.caveats]
    if model.posterior is not None:
        parts += [*_parameters(model), *_weak(model.posterior), _sampling(found)]
    if model.exact:
        parts += [Text(""), _exact_parameters(model)]
        if model.name.family == bivariate.NAME:
            parts.append(
                Text("first power: of x/z in r (alpha), of y/z in c (beta); second: of the other.")
            )
    return Group(*parts)


def models_table(found: FamilyComparison, rows: list[int]) -> RenderableType:
    """One row for each model listed, the most probable first."""
    best = found.best
    lowest_bic, lowest_aic = (min(getattr(m, k) for m in found.models) for k in ("bic", "aic"))
    heads = ["", "family", "order", "position", "K", "dAIC", "dBIC", "ln Z", "+-", "elpd", "+-"]
    heads += ["d elpd", "prob."]
    cells = []
    for i in rows:
        m = found.models[i]
        flag = "!" if m.warnings or not m.sound else ""
        cells.append(
            [
                ">" if m is best else "",
                m.name.family,
                m.name.order,
                m.name.position,
                str(m.n_parameters),
                f"{m.aic - lowest_aic:.1f}",
                f"{m.bic - lowest_bic:.1f}",
                f"{m.log_evidence:.2f}{flag}",
                _error(m.log_evidence_error),
                "" if m.elpd is None else f"{m.elpd:.1f}{'' if m.elpd_reliable else '?'}",
                "" if m.elpd_se is None else f"{m.elpd_se:.1f}",
                _difference(m, best),
                percent(found.probabilities[i]),
            ]
        )
    return _table(heads, cells, marked=0, spare=("dAIC", "K"))


def _error(value: float) -> str:
    return "exact" if value < 1e-5 else significant(value, 1)


def _difference(model: JointModel, best: JointModel) -> str:
    if model is best or model.elpd_pointwise is None or best.elpd_pointwise is None:
        return ""
    difference = model.elpd_pointwise - best.elpd_pointwise
    se = len(difference) ** 0.5 * float(difference.std(ddof=1))
    return f"{float(difference.sum()):+.1f} ({se:.1f})"


def _listed(found: FamilyComparison) -> list[int]:
    seen: set[tuple[str, str]] = set()
    out = []
    for i, model in enumerate(found.models):
        kind = model.name.family, model.name.position
        if i < LISTED or kind not in seen:
            out.append(i)
        seen.add(kind)
    return out


def _table(
    heads: list[str],
    rows: list[list[str]],
    *,
    marked: int | None = None,
    spare: tuple[str, ...] = (),
) -> RenderableType:
    columns = tuple(Column(head) for head in heads)
    cells = tuple(tuple(Cell(text) for text in row) for row in rows)
    return laid_out(Table(columns, cells, marked, spare=spare))


def _header(found: FamilyComparison) -> RenderableType:
    x, y, z = found.points.setup.position
    lines = [
        f"{len(found.points)} points from {found.points.source}, r and c jointly; camera stated at "
        f"({x:g}, {y:g}, {z:g})",
        f"noise: sigma of r {found.noise[0]}; sigma of c {found.noise[1]}",
    ]
    lines += [f"prior, {line}" for line in found.priors]
    if any(m.name.family == "pinhole" for m in found.models):
        lines.append(f"radial distortion in {found.request.radial} powers of the radius")
    return Text("\n".join(lines) + "\n")


def _verdict(found: FamilyComparison) -> RenderableType:
    text = Text("Verdict across families: ", style="bold")
    text.append(found.verdict.text)
    caveats = [Padding(Text(f"caveat: {c}."), (0, 0, 0, 2)) for c in found.verdict.caveats]
    return Group(Text(""), Padding(text, (0, 0, 0, 2)), *caveats)


def _parameters(model: JointModel) -> list[RenderableType]:
    posterior = model.posterior
    assert posterior is not None, "only a sampled model has parameters"
    rows = [_row(p) for p in posterior.parameters]
    heads = [str(model.name), "unit", "mean", "sd", "95% interval", "MCSE", "ESS", "R-hat"]
    return [_table(heads, rows, spare=("MCSE",))]


def _exact_parameters(model: JointModel) -> RenderableType:
    """Coefficients and noise of both axes, of which the closed form knows all."""
    rows = []
    for axis, posterior in zip(AXES, model.exact, strict=True):
        numbers = zip(*posterior.summary, posterior.intervals(INTERVAL_PROBABILITY), strict=True)
        for name, (mean, sd, (low, high)) in zip(posterior.model.names, numbers, strict=True):
            kind = name.split("_")[0]
            shown = name if kind == posterior.model.symbol else f"{name}_{axis}"
            interval = f"{rounded(low, sd)} to {rounded(high, sd)}"
            row = [shown, UNITS.get(kind, ""), rounded(mean, sd), significant(sd), interval]
            rows.append(row)
    return _table([f"{model.name} (exact)", "unit", "mean", "sd", "95% interval"], rows)


def _row(p: ParameterSummary) -> list[str]:
    unit = UNITS.get(p.name.split("_")[0], "")
    low, high = p.interval
    return [
        p.name,
        unit,
        rounded(p.mean, p.sd),
        significant(p.sd),
        f"{rounded(low, p.sd)} to {rounded(high, p.sd)}",
        significant(p.mcse_mean, 1),
        f"{min(p.ess_bulk, p.ess_tail):.0f}",
        f"{p.rhat:.3f}",
    ]


def _weak(posterior: SampledPosterior) -> list[RenderableType]:
    """Correlation matrix, and what moves together in it."""
    draws = posterior.chain.draws.reshape(-1, len(posterior.names))
    matrix = correlation(draws)
    numbers = [str(i + 1) for i in range(len(matrix))]
    rows = [
        [f"{i + 1} {name}", *(f"{value:.2f}" for value in matrix[i, : i + 1])]
        + [""] * (len(matrix) - i - 1)
        for i, name in enumerate(posterior.names)
    ]
    parts = [_table(["correlation", *numbers], rows, spare=tuple(numbers[::-1]))]
    for names, shares in weak_combinations(posterior.names, matrix):
        listed = ", ".join(f"{n} ({s:+.2f})" for n, s in zip(names, shares, strict=True))
        parts.append(Text(f"weakly identified together: {listed} move as one."))
    return parts


def _sampling(found: FamilyComparison) -> RenderableType:
    sampled = [m.posterior for m in found.models if m.posterior is not None]
    parameters = [p for s in sampled for p in s.parameters]
    text = (
        f"emcee, {len(sampled)} model{'s' * (len(sampled) > 1)}, seed {found.settings.seed}: "
        f"acceptance at least {min(s.chain.acceptance for s in sampled):.2f}, ESS at least "
        f"{min(min(p.ess_bulk, p.ess_tail) for p in parameters):.0f}, R-hat at most "
        f"{max(p.rhat for p in parameters):.3f}."
    )
    if found.sound:
        return Text(text)
    return Text(f"{text}\nNOT SOUND: some draws did not converge; see the caveats.", style="bold")
