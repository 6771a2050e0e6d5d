"""Tables of bad points, and of the orders under each treatment of them."""

from __future__ import annotations

from bayescal.comparison.outliers.records import PointRecord
from bayescal.comparison.outliers.results import AxisOutliers
from bayescal.comparison.outliers.treatments import Treatment
from bayescal.report.table import Cell, Column, Table, number_cell
from bayescal.report.views.words import MARK
from bayescal.rounding import percent, significant

# Points shown of each axis beside the suspicious ones, unless all are asked for.
SHOWN = 8
NAME = 14  # characters of a label in a table


def points_table(axis: AxisOutliers, *, everything: bool = True) -> Table:
    """Make a row for each point, the most suspicious first.

    Parameters
    ----------
    everything : bool, optional
        Whether to show every point, or the suspicious ones and a few more.
    """
    shown = axis.points if everything else axis.points[: max(len(axis.suspicious) + 2, SHOWN)]
    winner = axis.treatments[0].order
    columns = (
        Column("point"),
        Column(f"{axis.data.axis} px", "measured"),
        Column("residual px", "measured less least squares of all points"),
        Column("standard.", "residual over its own sd, sigma from the other points"),
        Column("leverage", "0 to 1: how far the point fixes its own prediction"),
        Column("Cook", "Cook's distance"),
        Column("rejected", "orders at which the chi-squared test removes the point"),
        Column("off px", "measured less what the mixture predicts"),
        Column("P(bad)", "posterior probability of being bad, under the mixture"),
        Column("weight t", "share of a good point's precision that Student-t noise leaves it"),
        Column("ln B without", f"of order {winner} against the best other, without the point"),
    )
    return Table(
        columns,
        tuple(_row(point, winner) for point in shown),
        spare=("leverage", "weight t"),
    )


def _row(point: PointRecord, winner: int) -> tuple[Cell, ...]:
    label = point.label if len(point.label) <= NAME else point.label[: NAME - 1] + "…"
    # A number of more than 0 says that the order still wins.
    changed = "" if point.order_without == winner else f" ({point.order_without} wins)"
    return (
        Cell(label, point.index),
        Cell(f"{point.measured:.6g}", point.measured),
        Cell(_signed(point.residual), point.residual),
        number_cell(point.standardised, lambda v: f"{v:+.1f}"),
        Cell(f"{point.leverage:.2f}", point.leverage),
        number_cell(point.cook, lambda v: f"{v:.2f}" if v >= 0.005 else "0.00"),
        Cell(_span(point.rejected_at), len(point.rejected_at)),
        Cell(_signed(point.off), point.off),
        Cell(percent(point.bad_probability), point.bad_probability),
        Cell(f"{point.weight:.2f}", point.weight),
        number_cell(point.log_bayes_factor_without, lambda v: f"{v:+.1f}{changed}"),
    )


def _signed(value: float) -> str:
    return f"{'-' if value < 0 else '+'}{significant(abs(value), 3)}"


def _span(orders: tuple[int, ...]) -> str:
    if len(orders) > 1 and orders == tuple(range(orders[0], orders[-1] + 1)):
        return f"{orders[0]}-{orders[-1]}"
    return ",".join(map(str, orders))


def treatments_table(axis: AxisOutliers) -> Table:
    """Compare the orders under each way of treating bad points."""
    orders = list(axis.treatments[0].log_evidence)
    columns = (
        Column("bad points"),
        Column("n", "points"),
        Column(f"order {orders[0]}", "log evidence of that order, and so on"),
        *(Column(f"order {k}") for k in orders[1:]),
        Column("wins"),
        Column("prob.", "posterior probability of the order that wins"),
        Column("all orders", "log evidence of the noise model, orders equally probable"),
    )
    return Table(columns, tuple(_treatment(axis, t, orders) for t in axis.treatments))


def _treatment(axis: AxisOutliers, found: Treatment, orders: list[int]) -> tuple[Cell, ...]:
    whole = found.n_points == len(axis.data)
    cells = [
        Cell(f"{found.log_evidence[k]:.1f}{MARK * (k in found.warnings)}", found.log_evidence[k])
        for k in orders
    ]
    name = (
        found.name.replace("Gaussian noise without", "without")
        .replace("Gaussian noise, nothing eliminated", "none eliminated")
        .replace("the outlier mixture", "mixture")
    )
    return (
        Cell(name),
        Cell(str(found.n_points), found.n_points),
        *cells,
        Cell(str(found.order), found.order),
        Cell(percent(found.probability[found.order]), found.probability[found.order]),
        Cell(f"{found.total:.1f}", found.total) if whole else Cell(""),
    )
