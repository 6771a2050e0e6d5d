"""Tables of results for a terminal: orders, coefficients, one order's facts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich import box
from rich.console import RenderableType
from rich.table import Table

from bayescal.comparison.goodness import GoodnessOfFit
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.verdict import percent
from bayescal.report.rounding import rounded, significant


def orders_table(axis: AxisComparison) -> RenderableType:
    """One row per order; the recommended one is marked."""
    known = axis.reference.source == "known"
    columns: list[tuple[str, Callable[[OrderResult], str]]] = [
        ("order", lambda r: str(r.order)),
        ("p", lambda r: str(r.order + 1)),
        ("RSS px²", lambda r: _short(r.rss_px2)),
        ("sigma^", lambda r: _maybe(r.fit.sigma_hat, significant_three)),
        (
            "chi2",
            lambda r: _maybe(r.goodness.chi2, lambda v: f"{v:.1f}" if v < 1e5 else f"{v:.3g}"),
        ),
        ("dof", lambda r: str(r.goodness.dof)),
        ("chi2/dof", lambda r: _maybe(r.goodness.chi2_reduced, significant_three)),
        ("p chi2", lambda r: _maybe(r.goodness.p_value, _p))
        if known
        else ("p F", lambda r: _maybe(r.goodness.f_p_value, _p)),
        ("dAIC", _delta(axis, "aic")),
        ("dAICc", _delta(axis, "aicc")),
        ("dBIC", _delta(axis, "bic")),
        ("ln Z", lambda r: _maybe(r.log_evidence, lambda v: f"{v:.2f}")),
        ("prob.", lambda r: _maybe(r.probability, percent)),
    ]
    table = start_table("", *(name for name, _ in columns))
    for result in axis.orders:
        chosen = result.order == axis.verdict.order
        cells = [value(result) for _, value in columns]
        table.add_row(">" if chosen else "", *cells, style="bold" if chosen else "")
    return table


def coefficients_table(axis: AxisComparison, result: OrderResult) -> RenderableType:
    """Coefficients of one order as sampled, with their uncertainties and diagnostics."""
    what = f"order {result.order}"
    if axis.verdict.order is None:
        what += " (lowest BIC)"
    table = start_table(
        f"{what}, {_unit(axis)}",
        "least sq.",
        "mean",
        "sd",
        "95% interval",
        "MCSE",
        "ESS bulk",
        "ESS tail",
        "R-hat",
    )
    for j, p in enumerate(result.posterior.parameters):
        sd = p.sd
        low, high = p.interval
        table.add_row(
            "tau / size" if p.name == "tau" else p.name,
            rounded(float(result.fit.coefficients[j]), sd) if j <= result.order else "",
            rounded(p.mean, sd),
            significant(sd),
            f"{rounded(low, sd)} to {rounded(high, sd)}",
            significant(p.mcse_mean, 1),
            f"{p.ess_bulk:.0f}",
            f"{p.ess_tail:.0f}",
            f"{p.rhat:.3f}",
        )
    return table


def exact_table(axis: AxisComparison, result: OrderResult) -> RenderableType:
    """Least squares and the closed form of one order, beside each other."""
    table = start_table(
        f"without sampling, {_unit(axis)}",
        "least squares",
        "standard error",
        "exact mean",
        "exact sd",
        "draws off by",
    )
    errors = result.fit.standard_errors
    for j, p in enumerate(result.posterior.parameters):
        fitted = j <= result.order
        error = float(errors[j]) if errors is not None and fitted else None
        table.add_row(
            "tau / size" if p.name == "tau" else p.name,
            rounded(float(result.fit.coefficients[j]), error or p.exact_sd) if fitted else "",
            _maybe(error, significant),
            rounded(p.exact_mean, p.exact_sd),
            significant(p.exact_sd),
            f"{p.deviation:.1f} MC errors",
        )
    return table


def facts(axis: AxisComparison, result: OrderResult) -> RenderableType:
    """Everything that is one number about one order."""
    good, found = result.goodness, result.criteria
    exact = result.posterior.exact
    facts: Sequence[tuple[str, str]] = [
        ("order", f"{result.order} ({result.order + 1} coefficients, K = {found.n_parameters})"),
        ("residual sum of squares", f"{result.rss_px2:.6g} px²"),
        ("sigma^ = sqrt(RSS/dof)", _maybe(result.fit.sigma_hat, lambda v: f"{v:.4g} px")),
        ("chi2, dof", f"{_maybe(good.chi2, lambda v: f'{v:.4g}')}, {good.dof}"),
        ("chi2/dof", _reduced(axis, good)),
        (
            "p-values of chi2",
            "blank: sigma is not known"
            if good.p_value is None or good.p_value_lower is None
            else f"upper tail {_p(good.p_value)}, lower tail {_p(good.p_value_lower)}",
        ),
        ("ln L, maximised", _maybe(found.log_likelihood, lambda v: f"{v:.4f}")),
        (
            "AIC, AICc, BIC",
            ", ".join(_maybe(v, lambda v: f"{v:.3f}") for v in (found.aic, found.aicc, found.bic)),
        ),
        (
            "ln evidence",
            _maybe(exact.log_evidence, lambda v: f"{v:.4f}")
            + _maybe(exact.log_evidence_error, lambda v: f" (quadrature error below {v:.0e})"),
        ),
    ]
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, value in facts:
        table.add_row(f"  {name}", value)
    return table


def _reduced(axis: AxisComparison, good: GoodnessOfFit) -> str:
    if good.chi2_reduced is None:
        return "blank: there is no sigma to measure chi2 in"
    if axis.reference.source != "known":
        return f"{good.chi2_reduced:.4g}, by construction: sigma is taken from the same residuals"
    return f"{good.chi2_reduced:.4g} (its sd if the model is right: {good.chi2_reduced_sd:.2g})"


def _unit(axis: AxisComparison) -> str:
    return "units of y" if axis.data.axis == "y" else "px"


def significant_three(value: float) -> str:
    """Three significant digits."""
    return significant(value, 3)


def start_table(first: str, *others: str) -> Table:
    """Start a table whose columns after the first are numbers."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="")
    table.add_column(first, no_wrap=True)
    for name in others:
        table.add_column(name, justify="right", no_wrap=True)
    return table


def _delta(axis: AxisComparison, key: str) -> Callable[[OrderResult], str]:
    values = [v for r in axis.orders if (v := getattr(r.criteria, key)) is not None]
    best = min(values) if values else None

    def cell(result: OrderResult) -> str:
        value = getattr(result.criteria, key)
        return "" if value is None or best is None else f"{value - best:.1f}"

    return cell


def _maybe(value: float | None, form: Callable[[float], str]) -> str:
    return "" if value is None else form(value)


def _short(value: float) -> str:
    return f"{value:.1f}" if 0.1 <= value < 1e6 else f"{value:.3g}"


def _p(value: float) -> str:
    if value < 0.001:
        return "<0.001"
    return f"{value:.3f}"
