"""How well each order predicts what it has not seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Blocks, Figure, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.report.views.views import Topic
from bayescal.report.views.words import IN_NUMBERS, MARK, one_decimal

if TYPE_CHECKING:  # a comparison without a defence does not pay for it
    from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
    from bayescal.comparison.defence.results import Defence

EXACT_ELPD = (
    "elpd: exact leave-one-out, one pixel value left out at a time; behind: the best order."
)
PSIS_ELPD = (
    "PSIS: the same from the draws, with its Monte Carlo error; ?: it can't be told, as a Pareto k "
    "is too large."
)
SAMPLED_ELPD = (
    "elpd: leave-one-out from the draws (PSIS), one pixel value left out at a time, with its "
    "Monte Carlo error beside PSIS (?: it can't be told, as a Pareto k is too large); behind: the "
    "best order."
)


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show leave-one-out differences with their errors."""
    defence, name = axis.defence, axis.data.axis
    if defence is None or not defence.prediction:
        return ()
    caption = (
        f"Leave-one-out of {name}: expected log predictive density behind the best order's, "
        "with its paired standard error."
    )
    drawn = (Figure("loo", comparison, caption, name),) if len(axis) > 1 else ()
    return (
        *drawn,
        Tabled(
            f"prediction-{name}",
            f"Leave-one-out of every order of {name}, nat.",
            prediction_table(axis, defence),
            tuple(prediction_lines(axis, defence)),
            folded=IN_NUMBERS if drawn else "",
        ),
    )


TOPIC = Topic(
    "prediction",
    "Prediction",
    "Leave-one-out asks only how well an unseen pixel would have been predicted.",
    of_axis,
)


def prediction_lines(axis: AxisComparison, defence: Defence) -> list[str]:
    """Say what to know of the table of prediction, a sentence or two each."""
    from bayescal.comparison.defence.argument import SMALL_SAMPLE

    drawn = any(p.psis is not None for p in defence.prediction.values())
    exact = f"{EXACT_ELPD} {PSIS_ELPD}" if drawn else EXACT_ELPD
    lines = [exact if axis.noise_model.conjugate else SAMPLED_ELPD]
    lines += _influential(axis, defence)
    if axis.data.n < SMALL_SAMPLE:
        lines.append(
            f"With {axis.data.n} points the standard errors may be up to twice too small "
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


def prediction_table(axis: AxisComparison, defence: Defence) -> Table:
    """Leave-one-out of every order, exact and from the draws."""
    grouped = any(p.group_elpd is not None for p in defence.prediction.values())
    drawn = any(p.psis is not None for p in defence.prediction.values())
    columns = [
        Column("elpd", "expected log pointwise predictive density, exact leave-one-out, nat"),
        Column("SE", "its standard error"),
        Column("behind", "elpd behind the best order's"),
        Column("± SE", "standard error of that difference, paired"),
        Column("p eff", "effective number of parameters"),
    ]
    if drawn:
        columns += [
            Column("PSIS", "elpd from the draws, Pareto-smoothed importance sampling, ± MC error"),
            Column("k max", "largest Pareto k; above 0.7 PSIS is no check at that point"),
        ]
    if grouped:
        columns.append(Column("by group", "the same with a whole group left out at a time"))
    rows = []
    for found in defence.prediction.values():
        loo = found.loo
        cells = [
            number_cell(value, one_decimal)
            for value in (loo.elpd, loo.se, abs(found.difference), found.difference_se, loo.p_eff)
        ]
        cells += _psis_cells(found.psis) if drawn else []
        rows.append([*cells, *[number_cell(found.group_elpd, one_decimal)] * grouped])
    spare = ("p eff", "SE", "k max", "PSIS")
    return order_table(list(defence.prediction), columns, rows, axis.verdict.order, spare=spare)


def _psis_cells(found: LeaveOneOut | None) -> list[Cell]:
    """Sum of the terms from draws, and their largest Pareto k."""
    if found is None or found.largest_k is None:
        return [Cell(""), Cell("")]
    k = found.largest_k
    error = f" ± {one_decimal(found.mcse)}" if found.reliable else MARK
    return [
        Cell(f"{one_decimal(found.elpd)}{error}", found.elpd),
        Cell(f"{k:.2f}" if k < 10 else "bad", k),
    ]
