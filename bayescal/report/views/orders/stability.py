"""Whether other points would have led to the same choice."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Block, Blocks, Figure, Part, Prose, Tabled
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.report.views.views import Topic
from bayescal.report.views.words import IN_NUMBERS
from bayescal.rounding import percent, significant

if TYPE_CHECKING:  # a comparison without a defence does not pay for it
    from bayescal.comparison.defence.results import Defence


def of_axis(comparison: Comparison, axis: AxisComparison) -> Blocks:
    """Show resamples, orders beyond the range and what world errors are worth."""
    defence, name = axis.defence, axis.data.axis
    if defence is None:
        return ()
    blocks: list[Block] = []
    if defence.resampled and len(axis) > 1:
        words = (
            f"Share of bootstrap resamples that each order of {name} wins, and its probability "
            "where orders beyond the range are compared too."
        )
        caption = f"Stability of the choice for {name}."
        blocks.append(Figure("bootstrap", comparison, words, name))
        table = stability_table(axis, defence)
        blocks.append(Tabled(f"stability-{name}", caption, table, folded=IN_NUMBERS))
    blocks += [Prose(line, "note") for line in (*world_lines(axis), *left_out(axis))]
    return tuple(blocks)


def both_axes(comparison: Comparison) -> Blocks:
    """Show the joint probabilities of both axes, which are independent."""
    axes = tuple(comparison.axes.values())
    alone = all(len(axis) == 1 for axis in axes)
    if len(axes) != 2 or alone or any(axis.defence is None for axis in axes):
        return ()
    table = joint_table(*axes)
    if table is None:
        return ()
    caption = "Posterior probability of each pair of orders; the axes are independent."
    return (
        Part(
            "Both axes together",
            (
                Figure("joint", comparison, caption),
                Tabled("joint", "Probability of each pair.", table, folded=IN_NUMBERS),
            ),
        ),
    )


TOPIC = Topic(
    "stability",
    "Stability",
    "Would other points, or higher orders, have led to another choice?",
    of_axis,
    after=both_axes,
)


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
    from bayescal.comparison.defence.stability import joint_probabilities

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


def left_out(axis: AxisComparison) -> list[str]:
    """Say which answers don't exist under this noise."""
    if axis.noise_model.conjugate:
        return []
    from bayescal.comparison.defence.defence import LEFT_OUT

    return [LEFT_OUT]
