"""The defence of a verdict, for a terminal."""

from __future__ import annotations

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from bayescal.comparison.defence.argument import SMALL_SAMPLE
from bayescal.comparison.defence.results import Defence
from bayescal.comparison.defence.sensitivity import TauSensitivity
from bayescal.comparison.defence.stability import joint_probabilities
from bayescal.comparison.leave_one_out import LeaveOneOut
from bayescal.comparison.results import AxisComparison
from bayescal.comparison.verdict import percent
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.report.grid import Cell, Column, Table, number_cell, order_table
from bayescal.report.other_noises import noises_table, other_noise_lines
from bayescal.report.render import indented, laid_out
from bayescal.rounding import significant

EXACT_ELPD = (
    "elpd: exact leave-one-out, one pixel value left out at a time; behind: the best order. "
    "PSIS: the same from the draws, with its Monte Carlo error."
)
SAMPLED_ELPD = (
    "elpd: leave-one-out from the draws (PSIS), one pixel value left out at a time, with its "
    "Monte Carlo error beside PSIS; behind: the best order."
)


# The table over tau shows the decades of its grid.
ON_DECADE = 1e-9


def defence_view(axis: AxisComparison) -> RenderableType:
    """Show prediction, prior sensitivity and stability of one axis."""
    defence = axis.defence
    if defence is None:
        return Text("")
    parts: list[RenderableType] = [
        Text(""),
        Text(f"  Defence of {axis.data.axis}: prediction and stability", style="bold"),
        laid_out(prediction_table(axis, defence)),
        *indented(prediction_lines(axis, defence)),
    ]
    if defence.tau is not None:
        parts.append(laid_out(tau_table(axis, defence.tau)))
    if defence.resampled:
        parts.append(laid_out(stability_table(axis, defence)))
    if defence.noises:
        parts.append(laid_out(noises_table(axis, defence.noises)))
        parts += indented(other_noise_lines(axis, defence.noises))
    parts += indented([*world_lines(axis), *left_out(axis)])
    return Group(*parts)


def prediction_lines(axis: AxisComparison, defence: Defence) -> list[str]:
    """Say what to know of the table of prediction, a sentence or two each."""
    lines = [EXACT_ELPD if axis.noise_model.name == GAUSSIAN.name else SAMPLED_ELPD]
    lines += _influential(axis, defence)
    if len(axis.data) < SMALL_SAMPLE:
        lines.append(
            f"With {len(axis.data)} points the standard errors may be up to twice too small "
            "(Sivula et al. 2020)."
        )
    if defence.group_source is not None:
        lines.append(
            f"Groups: points that share a {defence.group_source.removeprefix('column ')}. Their "
            "neighbours make leave-one-out optimistic; by group is the harder test."
        )
    return lines


def _influential(axis: AxisComparison, defence: Defence) -> list[str]:
    """Name the points whose Pareto k at the order shown is beyond the limit."""
    found = defence.prediction.get(axis.chosen.order)
    if found is None or not found.influential or found.psis is None:
        return []
    names = ("points " if len(found.influential) > 1 else "point ") + ", ".join(
        found.influential[:6]
    )
    more = f" and {len(found.influential) - 6} more" if len(found.influential) > 6 else ""
    return [
        f"Pareto k above {found.psis.k_limit:.2g} at order {axis.chosen.order}: {names}{more}; "
        "there PSIS can't be trusted: the draws can't tell what is predicted without the point."
    ]


def left_out(axis: AxisComparison) -> list[str]:
    """Say which answers don't exist under this noise."""
    if axis.noise_model.name == GAUSSIAN.name:
        return []
    from bayescal.comparison.defence.defence import LEFT_OUT

    return [LEFT_OUT]


def world_lines(axis: AxisComparison) -> list[str]:
    """Say what an unstated error of the world coordinates would be worth."""
    if not axis.world_units:
        return []
    first = axis.world_units[0]
    parts = [
        f"in {u.coordinate} {significant(u.nearest)} px and {significant(u.median)} px"
        for u in axis.world_units
    ]
    return [
        "Errors of the world coordinates are not stated. One unit of error is worth, at the "
        f"nearest point ({first.nearest_point}) and at the one of median depth "
        f"({first.median_point}): {'; '.join(parts)}."
    ]


def prediction_table(axis: AxisComparison, defence: Defence) -> Table:
    """Leave-one-out of every order, exact and from the draws."""
    grouped = any(p.group_elpd is not None for p in defence.prediction.values())
    columns = [
        Column("elpd", "expected log pointwise predictive density, exact leave-one-out, nat"),
        Column("SE", "its standard error"),
        Column("behind", "elpd behind the best order's"),
        Column("± SE", "standard error of that difference, paired"),
        Column("p eff", "effective number of parameters"),
        Column("PSIS", "elpd from the draws, Pareto-smoothed importance sampling, ± MC error"),
        Column("k max", "largest Pareto k; above 0.7 PSIS is no check at that point"),
    ]
    if grouped:
        columns.append(Column("by group", "the same with a whole group left out at a time"))
    rows = []
    for found in defence.prediction.values():
        loo = found.loo
        cells = [
            number_cell(value, _compact)
            for value in (loo.elpd, loo.se, abs(found.difference), found.difference_se, loo.p_eff)
        ]
        cells += _psis_cells(found.psis)
        rows.append([*cells, *[number_cell(found.group_elpd, _compact)] * grouped])
    spare = ("p eff", "SE", "k max", "PSIS")
    return order_table(list(defence.prediction), columns, rows, axis.verdict.order, spare=spare)


def _psis_cells(found: LeaveOneOut | None) -> list[Cell]:
    """Sum of the terms from draws, and their largest Pareto k."""
    if found is None or found.largest_k is None:
        return [Cell(""), Cell("")]
    k = found.largest_k
    return [
        Cell(f"{_compact(found.elpd)} ± {_compact(found.mcse)}", found.elpd),
        Cell(f"{k:.2f}" if k < 10 else "bad", k),
    ]


def _compact(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 1e5 else f"{value:.3g}"


def tau_table(axis: AxisComparison, found: TauSensitivity) -> Table:
    """Log evidence of every order at a few fixed tau."""
    decades = np.log10(found.tau)
    at = [int(i) for i in np.flatnonzero(np.abs(decades - np.round(decades)) < ON_DECADE)]
    shown = [significant(100 * float(found.tau[i])) for i in at]
    columns = [Column(f"{share}%", "", f"{share} %") for share in shown]
    rows = [[number_cell(float(row[i]), _compact) for i in at] for row in found.log_evidence]
    head = Column(
        "ln Z at fixed tau", "log evidence at these tau, fractions of the image", "order, at tau"
    )
    return order_table(found.orders, columns, rows, axis.verdict.order, head=head)


def stability_table(axis: AxisComparison, defence: Defence) -> Table:
    """How often each order wins over resamples, and its probability with orders beyond."""
    beyond = defence.beyond.probability if defence.beyond is not None else {}
    columns = [
        Column(
            f"wins, {b.unit}s resampled",
            f"share of {b.resamples} bootstrap resamples of the {b.unit}s in which the order is "
            "the most probable",
        )
        for b in defence.resampled
    ]
    last = "posterior probability were the orders beyond the range compared too"
    rows = [
        [
            *(number_cell(b.share.get(k), percent) for b in defence.resampled),
            number_cell(beyond[k], percent),
        ]
        for k in beyond
    ]
    columns.append(Column("prob. with orders beyond", last))
    return order_table(list(beyond), columns, rows, axis.verdict.order)


def joint_table(first: AxisComparison, second: AxisComparison) -> Table | None:
    """Probability of every pair of orders of two axes; None under a flat prior."""
    chances = [
        {r.order: r.probability for r in axis.orders if r.probability is not None}
        for axis in (first, second)
    ]
    if not all(chances):
        return None
    names = first.data.axis, second.data.axis
    corner = Column(f"joint, {names[0]} \\ {names[1]}", "", f"{names[0]} \\ {names[1]}")
    heads = [f"{names[1]} order {k}" for k in chances[1]]
    rows = [
        (Cell(f"{names[0]} order {k}", k), *(number_cell(float(p), percent) for p in row))
        for k, row in zip(chances[0], joint_probabilities(*chances), strict=True)
    ]
    return Table((corner, *map(Column, heads)), tuple(rows), spare=tuple(heads[::-1]))
