"""The orders beside each other, with every criterion."""

from __future__ import annotations

from collections.abc import Callable

from bayescal.comparison.criteria.information import CRITERIA
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.report.blocks import Blocks, Facts, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.report.views.orders.robust import robust_footnotes, robust_orders_table
from bayescal.report.views.views import Topic
from bayescal.report.views.words import noise_words, p_words, prior_words
from bayescal.rounding import percent, significant


def of_axis(_: Comparison, axis: AxisComparison) -> Blocks:
    """Show the assumptions, and the table that rests on them."""
    name = axis.data.axis
    gaussian = axis.noise_model.conjugate
    notes = footnotes(axis) if gaussian else robust_footnotes(axis)
    return (
        Facts(assumed(axis)),
        Tabled(
            f"orders-{name}",
            f"Orders of {name} compared; the recommended one is marked.",
            orders_table(axis) if gaussian else robust_orders_table(axis),
            (*notes, *_scatter(axis)),
        ),
    )


TOPIC = Topic(
    "orders",
    "The orders compared",
    "Each order is a model of the same pixels; every column judges it differently.",
    of_axis,
)


def assumed(axis: AxisComparison) -> tuple[tuple[str, str], ...]:
    """Name what the comparison rests on."""
    domain = axis.data.domain
    return (
        ("noise", noise_words(axis)),
        ("prior", prior_words(axis.prior)),
        ("domain", f"{axis.data.regressor} from {domain.lower:.3g} to {domain.upper:.3g}"),
    )


def orders_table(axis: AxisComparison) -> Table:
    """One row per order; the recommended one is marked."""
    known = axis.reference.source == "known"
    tested = (
        _column("p chi2", "p χ²", P_CHI2, lambda r: r.goodness.p_value, p_words)
        if known
        else _column("p F", "p (F)", P_F, lambda r: r.goodness.f_p_value, p_words)
    )
    several = len(axis) > 1  # one order alone has no probability

    def chance(result: OrderResult) -> float | None:
        return result.probability if several else None

    columns = [
        _column("p", "p", "number of coefficients", lambda r: r.order + 1, lambda v: f"{v:.0f}"),
        _column("RSS px²", "RSS, px²", "residual sum of squares", lambda r: r.rss_px2, _short),
        _column("sigma^", "\u03c3\u0302, px", SIGMA_HAT, lambda r: r.fit.sigma_hat, _three),
        _column("chi2", "χ²", CHI2, lambda r: r.goodness.chi2, _fixed(1)),
        _column("dof", "dof", DOF, lambda r: r.goodness.dof, lambda v: f"{v:.0f}"),
        _column("chi2/dof", "χ²/dof", REDUCED, lambda r: r.goodness.chi2_reduced, _three),
        tested,
        *(
            _column(f"d{c.name}", f"Δ{c.name}", f"{c.meaning}; less the smallest", above, _fixed(1))
            for c in CRITERIA
            for above in (_delta(axis, c.key),)
        ),
        _column("ln Z", "ln Z", LN_Z, lambda r: r.log_evidence, _fixed(2)),
        _column("prob.", "probability", PROBABILITY, chance, percent),
    ]
    return order_table(
        [r.order for r in axis.orders],
        [column for column, _ in columns],
        [[cell(r) for _, cell in columns] for r in axis.orders],
        axis.verdict.order,
        spare=("dAIC", "chi2", "sigma^", "dAICc", "p", "dof"),
    )


# What the columns mean, shown by a page.
SIGMA_HAT = "noise estimated from the residuals, √(RSS/dof)"
CHI2 = "sum of squared residuals in units of the reference sigma stated below"
DOF = "degrees of freedom: points less coefficients"
REDUCED = "χ² per degree of freedom; 1 by construction where sigma is taken from the same residuals"
P_CHI2 = "upper tail of χ² at the known sigma"
P_F = "p-value of the F test stated below"
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


def footnotes(axis: AxisComparison) -> list[str]:
    """Say what to know of the table under Gaussian noise, a sentence or two each."""
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
        f"{c.name} {min(values):.2f}"
        for c in CRITERIA
        if (values := [v for r in axis.orders if (v := r.criteria.values.get(c.key)) is not None])
    ]
    if best:
        heads = ", ".join(f"d{c.name}" for c in CRITERIA)
        lines.append(f"Smallest {', '.join(best)}; {heads} are above these.")
    return lines


def _scatter(axis: AxisComparison) -> list[str]:
    spread, dof = axis.scatter
    if spread is None:
        return []
    return [
        f"Points that share {axis.data.regressor} scatter by {spread:.2f} px "
        f"({dof} dof): noise plus what {axis.data.regressor} does not explain."
    ]


def _three(value: float) -> str:
    return significant(value, 3) if 1e-4 < abs(value) < 1e5 or value == 0 else f"{value:.2e}"


def _fixed(decimals: int) -> Callable[[float], str]:
    """Format with so many decimals, or as a power of ten where that would be too wide."""
    return lambda value: f"{value:.{decimals}f}" if abs(value) < 1e5 else f"{value:.3g}"


def _delta(axis: AxisComparison, key: str) -> Callable[[OrderResult], float | None]:
    values = [v for r in axis.orders if (v := r.criteria.values.get(key)) is not None]
    best = min(values) if values else None

    def above(result: OrderResult) -> float | None:
        value = result.criteria.values.get(key)
        return None if value is None or best is None else float(value - best)

    return above


def _short(value: float) -> str:
    return f"{value:.1f}" if 0.1 <= value < 1e5 else f"{value:.3g}"
