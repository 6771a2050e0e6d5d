"""The numbers to calibrate with."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bayescal.comparison.criteria.goodness import GoodnessOfFit
from bayescal.comparison.criteria.information import CRITERIA
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.report.blocks import Block, Blocks, Details, Prose, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.report.views.covariance import covariance_tabled
from bayescal.report.views.views import Topic
from bayescal.report.views.words import p_words
from bayescal.rounding import rounded, significant


def of_axis(_: Comparison, axis: AxisComparison) -> Blocks:
    """Show the coefficients of the recommended order, how they move together; others folded."""
    name, chosen = axis.data.axis, axis.chosen
    blocks: list[Block] = []
    if axis.verdict.order is None:
        blocks.append(Prose("No order is recommended; shown is the one of lowest BIC."))
    together = (_together(axis, chosen),)
    blocks += [_tabled(axis, chosen), Details("Covariance and correlations", together)]
    exact = exact_tabled(axis, chosen)
    if exact.table.rows:
        blocks.append(Details("Without sampling, as a check", (exact,)))
    for result in axis.orders:
        if result is not chosen:
            other = _tabled(axis, result), _together(axis, result)
            blocks.append(Details(f"Order {result.order} of {name}", other))
    return tuple(blocks)


TOPIC = Topic(
    "coefficients",
    "Coefficients",
    "Uncertainties carry two significant digits (JCGM 100:2008, 7.2.6); intervals are "
    "central and hold 95% of the posterior.",
    of_axis,
)


def _tabled(axis: AxisComparison, result: OrderResult) -> Tabled:
    name, symbol = axis.data.axis, axis.data.symbol
    caption, id = f"Coefficients of {name} at order {result.order}.", f"coefficients-{name}"
    if result is axis.chosen:
        caption = (
            f"Coefficients {symbol}_0 to {symbol}_{result.order} of {name} at order "
            f"{result.order}: of the powers 0 to {result.order} of {axis.data.regressor}."
        )
    else:
        id = f"{id}-{result.order}"
    return Tabled(id, caption, coefficients_table(axis, result))


def _together(axis: AxisComparison, result: OrderResult) -> Tabled:
    name = axis.data.axis
    return covariance_tabled(
        f"covariance-{name}-{result.order}",
        f"{name} at order {result.order}",
        *result.named_covariance(),
    )


def exact_tabled(axis: AxisComparison, result: OrderResult) -> Tabled:
    """Show what is known without sampling."""
    caption = "Least squares and closed form."
    return Tabled(f"exact-{axis.data.axis}", caption, exact_table(axis, result))


def coefficients_table(axis: AxisComparison, result: OrderResult, *, full: bool = False) -> Table:
    """Coefficients of one order as sampled, with their uncertainties and diagnostics.

    `full` shows bulk and tail ESS, and leaves least squares to the table beside it.
    """
    columns = [
        Column("mean", "posterior mean, rounded to its sd's two digits"),
        Column("sd", "posterior standard deviation, two significant digits"),
        Column("95% interval", "central (equal-tailed) interval of the draws", "95 % interval"),
        Column("MCSE", "Monte Carlo standard error of the mean"),
    ]
    if full:
        columns += [Column("ESS bulk"), Column("ESS tail")]
    else:
        least = Column("least sq.", "maximum likelihood", "least squares")
        smaller = "effective sample size, the smaller of bulk and tail"
        columns = [least, *columns, Column("ESS", smaller)]
    columns.append(
        Column("R-hat", "rank-normalised split R-hat; below 1.01 is converged", "R\u0302")
    )
    rows = []
    for j, p in enumerate(result.posterior.parameters):
        sd = p.sd
        low, high = p.interval
        cells = [
            Cell(rounded(p.mean, sd), p.mean),
            Cell(significant(sd), sd),
            Cell(f"{rounded(low, sd)} to {rounded(high, sd)}", low),
            Cell(significant(p.mcse_mean, 1), p.mcse_mean),
        ]
        if full:
            cells += [Cell(f"{v:.0f}", v) for v in (p.ess_bulk, p.ess_tail)]
        else:
            fitted = float(result.fit.coefficients[j]) if j <= result.order else None
            first = number_cell(fitted, partial(rounded, uncertainty=sd))
            cells = [first, *cells, Cell(f"{p.ess:.0f}", p.ess)]
        rows.append((Cell(_unitless(p.name), j), *cells, Cell(f"{p.rhat:.3f}", p.rhat)))
    head = Column(f"order {result.order}, {axis.data.unit}")
    spare = ("least sq.", "MCSE", "ESS", "ESS bulk")
    return Table((head, *columns), tuple(rows), spare=spare)


def _unitless(name: str) -> str:
    return {"tau": "tau / size", "scale": "scale / 1"}.get(name, name)


def exact_table(axis: AxisComparison, result: OrderResult) -> Table:
    """Least squares and the closed form of one order, beside each other."""
    columns = (
        Column(f"without sampling, {axis.data.unit}"),
        Column("least squares"),
        Column("standard error"),
        Column("exact mean"),
        Column("exact sd"),
        Column("draws off by", "distance of the draws' mean or sd, whichever is further"),
    )
    rows = []
    errors = result.fit.standard_errors
    for j, p in enumerate(result.posterior.parameters):
        if p.exact_mean is None or p.exact_sd is None or p.deviation is None:
            continue
        fitted = float(result.fit.coefficients[j]) if j <= result.order else None
        error = float(errors[j]) if errors is not None and j <= result.order else None
        unit = error or p.exact_sd
        rows.append(
            (
                Cell(_unitless(p.name), j),
                number_cell(fitted, partial(rounded, uncertainty=unit)),
                number_cell(error, significant),
                Cell(rounded(p.exact_mean, p.exact_sd), p.exact_mean),
                Cell(significant(p.exact_sd), p.exact_sd),
                Cell(f"{p.deviation:.1f} MC errors", p.deviation),
            )
        )
    return Table(columns, tuple(rows), spare=("draws off by",))


def facts(axis: AxisComparison, result: OrderResult) -> tuple[tuple[str, str], ...]:
    """Everything that is one number about one order: its name and itself."""
    good, found = result.goodness, result.criteria
    posterior = result.posterior
    kind = "quadrature" if posterior.exact is not None else "Monte Carlo"
    return (
        ("order", f"{result.order} ({result.order + 1} coefficients, K = {found.n_parameters})"),
        ("residual sum of squares", f"{result.rss_px2:.6g} px²"),
        ("sigma^ = sqrt(RSS/dof)", _maybe(result.fit.sigma_hat, lambda v: f"{v:.4g} px")),
        ("chi2, dof", f"{_maybe(good.chi2, lambda v: f'{v:.4g}')}, {good.dof}"),
        ("chi2/dof", _reduced(axis, good)),
        (
            "p-values of chi2",
            "blank: sigma is not known"
            if good.p_value is None or good.p_value_lower is None
            else f"upper tail {p_words(good.p_value)}, lower tail {p_words(good.p_value_lower)}",
        ),
        ("ln L, maximised", _maybe(found.log_likelihood, lambda v: f"{v:.4f}")),
        (
            ", ".join(c.name for c in CRITERIA),
            ", ".join(_maybe(found.values.get(c.key), lambda v: f"{v:.3f}") for c in CRITERIA),
        ),
        (
            "ln evidence",
            _maybe(posterior.log_evidence, lambda v: f"{v:.4f}")
            + _maybe(posterior.log_evidence_error, lambda v: f" ({kind} error {v:.0e})"),
        ),
    )


def _reduced(axis: AxisComparison, good: GoodnessOfFit) -> str:
    if good.chi2_reduced is None:
        return "blank: there is no sigma to measure chi2 in"
    if axis.reference.source == "highest-order":
        return f"{good.chi2_reduced:.4g}, by construction: sigma is taken from the same residuals"
    return f"{good.chi2_reduced:.4g} (its sd if the model is right: {good.chi2_reduced_sd:.2g})"


def _maybe(value: float | None, form: Callable[[float], str]) -> str:
    return "" if value is None else form(value)
