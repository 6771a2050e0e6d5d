"""Tables of results: orders, coefficients, one order's facts."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bayescal.comparison.goodness import GoodnessOfFit
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.verdict import percent
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.report.grid import Cell, Column, Table, number_cell, order_table
from bayescal.rounding import rounded, significant


def orders_table(axis: AxisComparison) -> Table:
    """One row per order; the recommended one is marked."""
    if axis.noise_model.name != GAUSSIAN.name:
        from bayescal.report.robust import robust_orders_table

        return robust_orders_table(axis)
    known = axis.reference.source == "known"
    tested = (
        _column("p chi2", "p χ²", P_CHI2, lambda r: r.goodness.p_value, p_words)
        if known
        else _column("p F", "p (F)", P_F, lambda r: r.goodness.f_p_value, p_words)
    )
    columns = [
        _column("p", "p", "number of coefficients", lambda r: r.order + 1, lambda v: f"{v:.0f}"),
        _column("RSS px²", "RSS, px²", "residual sum of squares", lambda r: r.rss_px2, _short),
        _column("sigma^", "\u03c3\u0302, px", SIGMA_HAT, lambda r: r.fit.sigma_hat, _three),
        _column("chi2", "χ²", CHI2, lambda r: r.goodness.chi2, _fixed(1)),
        _column("dof", "dof", DOF, lambda r: r.goodness.dof, lambda v: f"{v:.0f}"),
        _column("chi2/dof", "χ²/dof", REDUCED, lambda r: r.goodness.chi2_reduced, _three),
        tested,
        _column("dAIC", "ΔAIC", f"{AIC}; less the smallest", _delta(axis, "aic"), _fixed(1)),
        _column("dAICc", "ΔAICc", f"{AICC}; less the smallest", _delta(axis, "aicc"), _fixed(1)),
        _column("dBIC", "ΔBIC", f"{BIC}; less the smallest", _delta(axis, "bic"), _fixed(1)),
        _column("ln Z", "ln Z", LN_Z, lambda r: r.log_evidence, _fixed(2)),
        _column("prob.", "probability", PROBABILITY, lambda r: r.probability, percent),
    ]
    return order_table(
        [r.order for r in axis.orders],
        [column for column, _ in columns],
        [[cell(r) for _, cell in columns] for r in axis.orders],
        axis.verdict.order,
        spare=("dAIC", "chi2", "sigma^", "dAICc"),
    )


# What the columns mean, shown by a page.
SIGMA_HAT = "noise estimated from the residuals, √(RSS/dof)"
CHI2 = "sum of squared residuals in units of the reference sigma stated below"
DOF = "degrees of freedom: points less coefficients"
REDUCED = "χ² per degree of freedom; 1 by construction where sigma is taken from the same residuals"
P_CHI2 = "upper tail of χ² at the known sigma"
P_F = "p-value of the F test stated below"
AIC = "Akaike's criterion, -2 ln L + 2K"
AICC = "AIC corrected for few points"
BIC = "Schwarz's criterion, -2 ln L + K ln n"
LN_Z = "natural logarithm of the evidence, p(data given order), sigma and tau averaged over"
PROBABILITY = "posterior probability of the order, all equally probable beforehand"


def _column(
    head: str,
    title: str,
    note: str,
    value: Callable[[OrderResult], float | None],
    form: Callable[[float], str],
) -> tuple[Column, Callable[[OrderResult], Cell]]:
    """Make a column and the maker of its cells."""
    return Column(head, note, title), lambda r: number_cell(value(r), form)


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
            ess = min(p.ess_bulk, p.ess_tail)
            first = number_cell(fitted, partial(rounded, uncertainty=sd))
            cells = [first, *cells, Cell(f"{ess:.0f}", ess)]
        rows.append((Cell(_unitless(p.name), j), *cells, Cell(f"{p.rhat:.3f}", p.rhat)))
    head = Column(f"order {result.order}, {_unit(axis)}")
    spare = ("least sq.", "MCSE", "ESS", "ESS bulk")
    return Table((head, *columns), tuple(rows), spare=spare)


def _unitless(name: str) -> str:
    return {"tau": "tau / size", "scale": "scale / 1"}.get(name, name)


def exact_table(axis: AxisComparison, result: OrderResult) -> Table:
    """Least squares and the closed form of one order, beside each other."""
    columns = (
        Column(f"without sampling, {_unit(axis)}"),
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
            "AIC, AICc, BIC",
            ", ".join(_maybe(v, lambda v: f"{v:.3f}") for v in (found.aic, found.aicc, found.bic)),
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


def _unit(axis: AxisComparison) -> str:
    return "units of y" if axis.data.axis == "y" else "px"


def _three(value: float) -> str:
    return significant(value, 3) if 1e-4 < abs(value) < 1e5 or value == 0 else f"{value:.2e}"


def _fixed(decimals: int) -> Callable[[float], str]:
    """Format with so many decimals, or as a power of ten where that would be too wide."""
    return lambda value: f"{value:.{decimals}f}" if abs(value) < 1e5 else f"{value:.3g}"


def _delta(axis: AxisComparison, key: str) -> Callable[[OrderResult], float | None]:
    values = [v for r in axis.orders if (v := getattr(r.criteria, key)) is not None]
    best = min(values) if values else None

    def above(result: OrderResult) -> float | None:
        value = getattr(result.criteria, key)
        return None if value is None or best is None else float(value - best)

    return above


def _maybe(value: float | None, form: Callable[[float], str]) -> str:
    return "" if value is None else form(value)


def _short(value: float) -> str:
    return f"{value:.1f}" if 0.1 <= value < 1e5 else f"{value:.3g}"


def p_words(value: float) -> str:
    """Probability of a tail, to three digits."""
    if value < 0.001:
        return "<0.001"
    return f"{value:.3f}"
