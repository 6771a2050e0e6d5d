"""What ``outliers`` prints."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.text import Text

from bayescal.comparison.outliers.records import PointRecord
from bayescal.comparison.outliers.results import AxisOutliers, OutlierStudy, Treatment
from bayescal.comparison.verdict import percent
from bayescal.report.grid import Cell, Column, Table, number_cell
from bayescal.report.noise import MARK, floor_words
from bayescal.report.render import indented, laid_out
from bayescal.rounding import counted

# Points shown of each axis beside the suspicious ones, unless all are asked for.
SHOWN = 8
NAME = 14  # characters of a label in a table


def outliers_view(study: OutlierStudy, *, everything: bool = False) -> RenderableType:
    """Everything that ``outliers`` prints.

    Parameters
    ----------
    study : OutlierStudy
    everything : bool, optional
        Whether to show every point.
    """
    points = study.points
    parts: list[RenderableType] = [Text(f"{len(points)} points from {points.source}\n")]
    for axis in study.axes.values():
        parts += _axis_view(axis, study.significance, everything)
    if not study.sound:
        parts.append(
            Text(
                f"{MARK} an evidence that should not be trusted, or its chains did not "
                "converge; --json says why.",
                style="bold",
            )
        )
    return Group(*parts)


def _axis_view(
    axis: AxisOutliers, significance: float, everything: bool
) -> Iterable[RenderableType]:
    data = axis.data
    title = Text(f"{data.axis} = polynomial of {data.regressor}", style="bold")
    title.append(f", sigma {axis.noise_source}; residuals of order {axis.order}", style="not bold")
    yield title
    yield laid_out(points_table(axis, everything=everything))
    yield from indented(footnotes(axis, significance, everything=everything))
    yield Text("")
    yield from indented(axis.explanations or ("no point is suspicious.",))
    yield laid_out(treatments_table(axis))
    yield from indented(
        [
            "ln Z of each order; evidences of fewer points are of other data, so that only orders "
            "can be compared on that line, not noise models.",
            f"Verdict on {data.axis}: {axis.verdict}",
        ]
    )
    yield Text("")


def points_table(axis: AxisOutliers, *, everything: bool = True) -> Table:
    """Make a row for each point, the most suspicious first.

    Parameters
    ----------
    axis : AxisOutliers
    everything : bool, optional
        Whether to show every point, or the suspicious ones and a few more.
    """
    unit = "y" if axis.data.axis == "y" else "px"
    shown = axis.points if everything else axis.points[: max(len(axis.suspicious) + 2, SHOWN)]
    winner = axis.treatments[0].order
    columns = (
        Column("point"),
        Column("y" if unit == "y" else f"{axis.data.axis} px", "measured"),
        Column(f"residual {unit}", "measured less least squares"),
        Column("standard.", "residual over its own sd, sigma from the other points"),
        Column("leverage", "0 to 1: how far the point fixes its own prediction"),
        Column("Cook", "Cook's distance"),
        Column("rejected", "orders at which the chi-squared test removes the point"),
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
        Cell(f"{point.residual:+.3g}", point.residual),
        number_cell(point.standardised, lambda v: f"{v:+.1f}"),
        Cell(f"{point.leverage:.2f}", point.leverage),
        number_cell(point.cook, lambda v: f"{v:.2f}" if v >= 0.005 else "0.00"),
        Cell(_span(point.rejected_at), len(point.rejected_at)),
        Cell(percent(point.bad_probability), point.bad_probability),
        Cell(f"{point.weight:.2f}", point.weight),
        number_cell(point.log_bayes_factor_without, lambda v: f"{v:+.1f}{changed}"),
    )


def _span(orders: tuple[int, ...]) -> str:
    if len(orders) > 1 and orders == tuple(range(orders[0], orders[-1] + 1)):
        return f"{orders[0]}-{orders[-1]}"
    return ",".join(map(str, orders))


def footnotes(axis: AxisOutliers, significance: float, *, everything: bool) -> list[str]:
    """Say what the table of the points does not."""
    winner = axis.treatments[0]
    values = winner.log_evidence
    rest = [v for k, v in values.items() if k != winner.order]
    lines = [
        f"P(bad): outlier mixture; weight t: Student-t noise; rejected: chi-squared test, "
        f"{100 * significance:g} % for all points together. ± of a prediction: of the model, "
        f"without the noise of a reading.{floor_words(axis.data, axis.level)}"
    ]
    if rest:
        lines[0] += (
            f" ln B without: of order {winner.order} under Gaussian noise, "
            f"{values[winner.order] - max(rest):+.1f} with all points."
        )
    hidden = len(axis.points) - max(len(axis.suspicious) + 2, SHOWN)
    if not everything and hidden > 0:
        others = axis.points[-hidden:]
        largest = max(abs(p.standardised or 0.0) for p in others)
        most = max(p.bad_probability for p in others)
        lines.append(
            f"The other {counted(hidden, 'point')}: at most {largest:.1f} standard deviations, "
            f"P(bad) at most {percent(most)}; --all shows them."
        )
    return lines


def treatments_table(axis: AxisOutliers) -> Table:
    """Compare the orders under each way of treating bad points."""
    orders = list(axis.treatments[0].log_evidence)
    columns = (
        Column("bad points"),
        Column("n", "points"),
        *(Column(f"order {k}", f"log evidence of order {k}") for k in orders),
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
