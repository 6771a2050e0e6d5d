"""Tables of results for a terminal: orders, coefficients, one order's facts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from bayescal.comparison.goodness import GoodnessOfFit
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.verdict import percent
from bayescal.inference.posterior import Posterior
from bayescal.report.render import WIDTH
from bayescal.rounding import rounded, significant


def orders_table(axis: AxisComparison) -> RenderableType:
    """One row per order; the recommended one is marked."""
    known = axis.reference.source == "known"
    columns: list[tuple[str, Callable[[OrderResult], str]]] = [
        ("order", lambda r: str(r.order)),
        ("p", lambda r: str(r.order + 1)),
        ("RSS px²", lambda r: _short(r.rss_px2)),
        ("sigma^", lambda r: _maybe(r.fit.sigma_hat, _three)),
        ("chi2", lambda r: _maybe(r.goodness.chi2, _fixed(1))),
        ("dof", lambda r: str(r.goodness.dof)),
        ("chi2/dof", lambda r: _maybe(r.goodness.chi2_reduced, _three)),
        ("p chi2", lambda r: _maybe(r.goodness.p_value, _p))
        if known
        else ("p F", lambda r: _maybe(r.goodness.f_p_value, _p)),
        ("dAIC", _delta(axis, "aic")),
        ("dAICc", _delta(axis, "aicc")),
        ("dBIC", _delta(axis, "bic")),
        ("ln Z", lambda r: _maybe(r.log_evidence, _fixed(2))),
        ("prob.", lambda r: _maybe(r.probability, percent)),
    ]
    heads = ["", *(name for name, _ in columns)]
    chosen = [r.order == axis.verdict.order for r in axis.orders]
    rows = [
        [">" if mark else "", *(value(r) for _, value in columns)]
        for mark, r in zip(chosen, axis.orders, strict=True)
    ]
    return make_table(
        heads,
        rows,
        bold=chosen.index(True) if any(chosen) else None,
        spare=("dAIC", "chi2", "sigma^", "dAICc"),
    )


def coefficients_table(
    axis: AxisComparison, result: OrderResult, *, full: bool = False
) -> RenderableType:
    """Coefficients of one order as sampled, with their uncertainties and diagnostics.

    `full` shows bulk and tail ESS, and leaves least squares to the table beside it.
    """
    heads = ["mean", "sd", "95% interval", "MCSE"]
    heads = [*heads, "ESS bulk", "ESS tail"] if full else ["least sq.", *heads, "ESS"]
    rows = []
    for j, p in enumerate(result.posterior.parameters):
        sd = p.sd
        low, high = p.interval
        cells = [
            rounded(p.mean, sd),
            significant(sd),
            f"{rounded(low, sd)} to {rounded(high, sd)}",
            significant(p.mcse_mean, 1),
        ]
        if full:
            cells += [f"{p.ess_bulk:.0f}", f"{p.ess_tail:.0f}"]
        else:
            fitted = rounded(float(result.fit.coefficients[j]), sd) if j <= result.order else ""
            cells = [fitted, *cells, f"{min(p.ess_bulk, p.ess_tail):.0f}"]
        rows.append([_unitless(p.name), *cells, f"{p.rhat:.3f}"])
    heads = [f"order {result.order}, {_unit(axis)}", *heads, "R-hat"]
    return make_table(heads, rows, spare=("least sq.", "MCSE", "ESS", "ESS bulk"))


def _unitless(name: str) -> str:
    return {"tau": "tau / size", "scale": "scale / 1"}.get(name, name)


def exact_table(axis: AxisComparison, result: OrderResult) -> RenderableType:
    """Least squares and the closed form of one order, beside each other."""
    heads = [
        f"without sampling, {_unit(axis)}",
        "least squares",
        "standard error",
        "exact mean",
        "exact sd",
        "draws off by",
    ]
    rows = []
    errors = result.fit.standard_errors
    for j, p in enumerate(result.posterior.parameters):
        if p.exact_mean is None or p.exact_sd is None or p.deviation is None:
            continue
        fitted = j <= result.order
        error = float(errors[j]) if errors is not None and fitted else None
        rows.append(
            [
                _unitless(p.name),
                rounded(float(result.fit.coefficients[j]), error or p.exact_sd) if fitted else "",
                _maybe(error, significant),
                rounded(p.exact_mean, p.exact_sd),
                significant(p.exact_sd),
                f"{p.deviation:.1f} MC errors",
            ]
        )
    return make_table(heads, rows, spare=("draws off by",))


def facts(axis: AxisComparison, result: OrderResult) -> RenderableType:
    """Everything that is one number about one order."""
    good, found = result.goodness, result.criteria
    posterior = result.posterior
    sampled = not isinstance(posterior, Posterior)
    error = f" ({'Monte Carlo' if sampled else 'quadrature'} error below {{:.0e}})"
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
            _maybe(posterior.log_evidence, lambda v: f"{v:.4f}")
            + _maybe(posterior.log_evidence_error, error.format),
        ),
    ]
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for name, value in facts:
        table.add_row(f"  {name}", value)
    return table


def _reduced(axis: AxisComparison, good: GoodnessOfFit) -> str:
    if good.chi2_reduced is None:
        return "blank: there is no sigma to measure chi2 in"
    if axis.reference.source == "highest-order":
        return f"{good.chi2_reduced:.4g}, by construction: sigma is taken from the same residuals"
    return f"{good.chi2_reduced:.4g} (its sd if the model is right: {good.chi2_reduced_sd:.2g})"


def _unit(axis: AxisComparison) -> str:
    return "units of y" if axis.data.axis == "y" else "px"


def _three(value: float) -> str:
    return significant(value, 3) if 1e-4 < abs(value) < 1e5 or value == 0 else f"{value:.2e}"


def _fixed(decimals: int) -> Callable[[float], str]:
    """Format with so many decimals, or as a power of ten where that would be too wide."""
    return lambda value: f"{value:.{decimals}f}" if abs(value) < 1e5 else f"{value:.3g}"


def make_table(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    bold: int | None = None,
    spare: Sequence[str] = (),
) -> RenderableType:
    """Lay out cells, the columns after the first as numbers, within 100 columns.

    Parameters
    ----------
    heads : sequence of str
    rows : sequence of sequence of str
        One cell for each head.
    bold : int, optional
        The row to stress.
    spare : sequence of str
        Heads of the columns to leave out, in this order, where the numbers are so wide
        that not all fit; a line says which.
    """
    widths = [max([len(head), *(len(row[i]) for row in rows)]) for i, head in enumerate(heads)]
    kept, dropped = list(range(len(heads))), []
    for head in spare:
        if sum(widths[i] + 2 for i in kept) <= WIDTH:
            break
        if head in heads:
            dropped.append(head)
            kept.remove(heads.index(head))
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="")
    for column in kept:
        table.add_column(heads[column], justify="right" if column else "left", no_wrap=True)
    for number, row in enumerate(rows):
        table.add_row(*(row[i] for i in kept), style="bold" if number == bold else "")
    if not dropped:
        return table
    return Group(table, Text(f"  Too wide to show: {', '.join(dropped)} (--json has them)."))


def _delta(axis: AxisComparison, key: str) -> Callable[[OrderResult], str]:
    values = [v for r in axis.orders if (v := getattr(r.criteria, key)) is not None]
    best = min(values) if values else None

    def cell(result: OrderResult) -> str:
        value = getattr(result.criteria, key)
        return "" if value is None or best is None else _fixed(1)(value - best)

    return cell


def _maybe(value: float | None, form: Callable[[float], str]) -> str:
    return "" if value is None else form(value)


def _short(value: float) -> str:
    return f"{value:.1f}" if 0.1 <= value < 1e5 else f"{value:.3g}"


def _p(value: float) -> str:
    if value < 0.001:
        return "<0.001"
    return f"{value:.3f}"
