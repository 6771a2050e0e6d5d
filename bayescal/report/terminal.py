"""What the commands print: tables with the words that explain them, 100 columns wide."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.prior.amplitudes import PriorRule
from bayescal.report.noise import level_words, noise_kind, robust_footnotes
from bayescal.report.render import WIDTH as WIDTH
from bayescal.report.render import indented, laid_out, listed
from bayescal.report.render import render as render
from bayescal.report.tables import coefficients_table, exact_table, facts, orders_table
from bayescal.rounding import significant


def comparison_view(comparison: Comparison) -> RenderableType:
    """Everything that ``compare`` prints."""
    parts: list[RenderableType] = [header(comparison)]
    for axis in comparison.axes.values():
        parts += [
            axis_title(axis),
            laid_out(orders_table(axis)),
            *indented(footnotes(axis)),
            verdict_view(axis),
        ]
        if axis.defence is not None:
            parts += _defended(axis)
        if axis.verdict.order is None:
            parts.append(Text("\n  No order is recommended; shown is the one of lowest BIC."))
        parts += [laid_out(coefficients_table(axis, axis.chosen)), Text("")]
    parts += _across(comparison)
    parts.append(sampling_line(comparison))
    return Group(*parts)


def _defended(axis: AxisComparison) -> list[RenderableType]:
    from bayescal.report.adequacy import adequacy_view
    from bayescal.report.defence import defence_view

    tests = [adequacy_view(axis.adequacy, axis.chosen.order)] if axis.adequacy else []
    return [defence_view(axis), *tests]


def _across(comparison: Comparison) -> list[RenderableType]:
    """Joint probabilities of both axes, or how to ask for them and more."""
    if any(axis.defence is None for axis in comparison.axes.values()):
        more = "leave-one-out, prior sensitivity, stability, adequacy, other noise, orders beyond"
        return [Text(f"Would it persuade a referee? --defend adds {more}.\n")]
    if len(comparison.axes) != 2:
        return []
    from bayescal.report.defence import joint_table

    joint = joint_table(*comparison.axes.values())
    return [] if joint is None else [laid_out(joint), Text("")]


def fit_view(comparison: Comparison) -> RenderableType:
    """Everything that ``fit`` prints: each axis's one order in full."""
    parts: list[RenderableType] = [header(comparison)]
    for axis in comparison.axes.values():
        result = axis.orders[0]
        parts += [axis_title(axis), listed(facts(axis, result)), *_caveats(axis)]
        parts += [laid_out(coefficients_table(axis, result, full=True))]
        parts += [laid_out(exact_table(axis, result)), Text("")]
    parts.append(sampling_line(comparison))
    return Group(*parts)


def header(comparison: Comparison) -> RenderableType:
    """Say what was analysed, under which assumptions."""
    return Text("\n".join(header_lines(comparison)) + "\n")


def header_lines(comparison: Comparison) -> list[str]:
    """Points, camera and notes, a line each."""
    lines = []
    points = comparison.points
    if points is not None:
        x, y, z = points.setup.position
        size = " x ".join(
            "?" if s is None else f"{s:g}" for s in (points.setup.width, points.setup.height)
        )
        end = "bottom (c = height - row)" if points.setup.c_from_bottom else "top"
        lines.append(f"{len(points)} points from {points.source}, {comparison.family} family")
        lines.append(f"camera at ({x:g}, {y:g}, {z:g}), image {size} px, c counted from the {end}")
    return lines + [f"note: {note}" for note in comparison.notes]


def axis_title(axis: AxisComparison) -> RenderableType:
    """Say what the axis is, and under which noise level and prior."""
    data, domain = axis.data, axis.data.domain
    text = Text(f"{data.axis} = polynomial of {data.regressor}", style="bold")
    text.append(
        f", {data.regressor} from {domain.lower:.3g} to {domain.upper:.3g}", style="not bold"
    )
    return Group(text, _assumed(axis))


def _assumed(axis: AxisComparison) -> Text:
    prior = prior_words(axis).replace("; tau", ";\n         tau")
    noise = fill(  # robust noise has many words: what wraps stands below them, not the margin
        noise_words(axis), WIDTH, initial_indent="  noise: ", subsequent_indent=" " * 9
    )
    return Text(f"{noise}\n  prior: {prior}")


def noise_words(axis: AxisComparison) -> str:
    """Name the noise model and where its level comes from."""
    return noise_kind(axis) + level_words(axis.noise)


def prior_words(axis: AxisComparison) -> str:
    """Name the prior of an axis and its numbers."""
    return rule_words(axis.prior)


def rule_words(rule: PriorRule) -> str:
    """Name a prior and its numbers."""
    if rule.name == "flat":
        return "flat; improper, so that there is no evidence and no probability of an order"
    if rule.name == "stated":
        return "stated in the setup: a normal for each Legendre amplitude"
    half = f"{rule.size / 2:g}"
    low, high = rule.tau_bounds
    tau = (
        f"= {rule.tau:g}"
        if rule.tau is not None
        else f"inferred, log-uniform {low:.3g} to {high:g} ({low * rule.size:.3g} to "
        f"{high * rule.size:.4g} px)"
    )
    return (
        f"field; b0 ~ N({rule.centre:g}, {half}), b1 ~ N(0, {half}), bj ~ N(0, tau * "
        f"{rule.size:g}) px; tau {tau}"
    )


def footnotes(axis: AxisComparison) -> list[str]:
    """Say what to know of the table of orders, a sentence or two each."""
    if axis.noise_model.name != GAUSSIAN.name:
        return [*robust_footnotes(axis), *_scatter_line(axis)]
    reference, lines = axis.reference, []
    if axis.data.sd is not None and reference.source == "known":
        lines.append("chi2 uses the points' own deviations; p chi2 is its upper tail.")
    elif reference.source == "known":
        lines.append(
            f"chi2 uses the known sigma, {reference.value:g} px; p chi2 is its upper tail."
        )
    elif reference.source == "replicates":
        lines.append(
            f"chi2 uses sigma = {significant(reference.value or 0.0, 3)} px from replicates "
            f"({reference.dof} dof); p F: lack of fit against them."
        )
    elif reference.value is not None:
        highest = axis.orders[-1].order
        lines.append(
            f"chi2 uses sigma = {significant(reference.value, 3)} px, the residuals' own at "
            f"order {highest} ({reference.dof} dof): it is relative to that order and tests "
            "nothing by itself."
        )
        if len(axis.orders) > 1:
            lines.append(f"p F: F test of the dropped orders against order {highest}.")
    else:
        lines.append(
            f"chi2 is blank: sigma is not known and order {axis.orders[-1].order} leaves no "
            "residual to take it from."
        )
    best = [
        f"{name} {min(values):.2f}"
        for name, key in (("AIC", "aic"), ("AICc", "aicc"), ("BIC", "bic"))
        if (values := [v for r in axis.orders if (v := getattr(r.criteria, key)) is not None])
    ]
    if best:
        lines.append(f"Smallest {', '.join(best)}; dAIC, dAICc, dBIC are above these.")
    return lines + _scatter_line(axis)


def _scatter_line(axis: AxisComparison) -> list[str]:
    spread, dof = axis.scatter
    if spread is None:
        return []
    return [
        f"Points that share {axis.data.regressor} scatter by {spread:.2f} px "
        f"({dof} dof): noise plus what {axis.data.regressor} does not explain."
    ]


def verdict_view(axis: AxisComparison) -> RenderableType:
    """Say the verdict in words, with its caveats."""
    text = Text(f"Verdict on {axis.data.axis}: ", style="bold")
    text.append(axis.verdict.text)
    return Group(Text(""), Padding(text, (0, 0, 0, 2)), *_caveats(axis))


def _caveats(axis: AxisComparison) -> list[RenderableType]:
    return indented(f"caveat: {caveat}." for caveat in caveats(axis))


def caveats(axis: AxisComparison) -> list[str]:
    """Caveats of the verdict that the block of adequacy does not say."""
    said: set[str] = set()  # by the block of adequacy
    if axis.adequacy:
        from bayescal.comparison.adequacy.outcome import concerns

        said = set(concerns(axis.adequacy))
    return [caveat for caveat in axis.verdict.caveats if caveat not in said]


def sampling_line(comparison: Comparison) -> RenderableType:
    """Whether the draws can be trusted, for all models at once."""
    text = Text(sampling_words(comparison))
    if comparison.sound:
        return text
    return Group(text, Text(NOT_SOUND, style="bold"))


NOT_SOUND = (
    "NOT SOUND: some draws did not converge or disagree with the closed form, or an evidence "
    "should not be trusted; see above."
)


def sampling_words(comparison: Comparison) -> str:
    """Say how the sampling of all models went."""
    results = [r for axis in comparison.axes.values() for r in axis.orders]
    chains = [r.posterior.chain for r in results]
    parameters = [p for r in results for p in r.posterior.parameters]
    ess = min(min(p.ess_bulk, p.ess_tail) for p in parameters)
    return (
        f"emcee, {len(results)} model{'s' * (len(results) > 1)}, seed {comparison.seed}: "
        f"acceptance at least {min(c.acceptance for c in chains):.2f}, autocorrelation time at "
        f"most {max(c.autocorrelation_time for c in chains):.2f} steps, ESS at least {ess:.0f}, "
        f"R-hat at most {max(p.rhat for p in parameters):.3f}; {_checked(results)}."
    )


def _checked(results: Sequence[OrderResult]) -> str:
    """Say what draws and evidences were checked against."""
    deviations = [p.deviation for r in results for p in r.posterior.parameters]
    compared = [d for d in deviations if d is not None]
    if compared:
        return (
            f"means and sds within {max(compared):.1f} Monte Carlo errors of the closed form "
            "(limit 5)"
        )
    errors = [r.posterior.log_evidence_error or 0.0 for r in results]
    return f"evidences to within {significant(max(errors), 1)} nat (limit 0.1)"
