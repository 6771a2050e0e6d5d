"""The table of orders under robust noise, which has no chi-squared and no criteria."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.noise.world_errors import WorldErrors
from bayescal.report.numbers import point_chances
from bayescal.report.table import Cell, Column, Table, number_cell, order_table
from bayescal.report.views.words import MARK
from bayescal.rounding import percent, significant

# A point is shown as bad above this probability, and so many of them.
BAD, SHOWN = 0.5, 4


def robust_orders_table(axis: AxisComparison) -> Table:
    """One row per order under robust noise; the recommended one is marked."""
    level = axis.noise.parameter
    columns: list[tuple[Column, Callable[[OrderResult], Cell]]] = [
        (Column("p", "number of coefficients"), _size),
        (Column("RSS px²", "residual sum of squares of least squares, for comparison"), _rss),
    ]
    if axis.noise.value is None:
        columns.append((Column(level, "scale of the noise, posterior mean and sd"), _mean(level)))
    heads = axis.noise_model.columns
    columns += [
        (Column(heads[name][0], f"{heads[name][1]}, posterior mean and sd"), _mean(name))
        for name in axis.noise_model.parameters
    ]
    if axis.noise_model.tells_bad:
        columns.append((Column("bad points", "more probably bad than good"), _bad_points(axis)))
    columns += [
        (
            Column("ln Z", f"log evidence; {MARK}: not to be trusted"),
            _evidence,
        ),
        (Column("MC error", "Monte Carlo standard error of ln Z, nat"), error_cell),
        (Column("prob.", "posterior probability of the order", "probability"), _chance),
    ]
    return order_table(
        [r.order for r in axis.orders],
        [column for column, _ in columns],
        [[cell(r) for _, cell in columns] for r in axis.orders],
        axis.verdict.order,
        spare=("RSS px²", "p"),
    )


def robust_footnotes(axis: AxisComparison) -> list[str]:
    """Say what the table of orders under robust noise does not."""
    gaussian = axis.noise_model.name == WorldErrors.name
    where = "points of one deviation" if gaussian else "Gaussian noise"
    lines = [
        "RSS is of least squares, for comparison: chi-squared, F tests, AIC and BIC belong to "
        f"{where}. ln Z by importance sampling, checked by bridge sampling; the other "
        "columns are posterior means ± sd.",
    ]
    if axis.noise_model.tells_bad:
        lines.append("Bad points: more probably bad than good, the worst first.")
    if any(r.warnings for r in axis.orders):
        lines.append(f"{MARK} marks an evidence that should not be trusted; the caveats say why.")
    return lines


def _size(result: OrderResult) -> Cell:
    return Cell(str(len(result.fit.coefficients)), len(result.fit.coefficients))


def _rss(result: OrderResult) -> Cell:
    return Cell(f"{result.rss_px2:.1f}", result.rss_px2)


def _evidence(result: OrderResult) -> Cell:
    mark = MARK * bool(result.warnings)
    return number_cell(result.log_evidence, lambda v: f"{v:.2f}{mark}")


def error_cell(result: OrderResult) -> Cell:
    """Monte Carlo error of an evidence."""
    return number_cell(result.posterior.log_evidence_error, lambda v: significant(v, 1))


def _chance(result: OrderResult) -> Cell:
    mark = MARK * bool(result.warnings)
    return number_cell(result.probability, lambda v: percent(v) + mark)


def _mean(name: str) -> Callable[[OrderResult], Cell]:
    def cell(result: OrderResult) -> Cell:
        found = result.posterior[name]
        return Cell(f"{significant(found.mean)} ± {significant(found.sd, 1)}", found.mean)

    return cell


def _bad_points(axis: AxisComparison) -> Callable[[OrderResult], Cell]:
    def cell(result: OrderResult) -> Cell:
        found = point_chances(result)
        if found is None or found.bad is None:
            return Cell("")
        bad = np.flatnonzero(found.bad > BAD)
        worst = bad[np.argsort(-found.bad[bad], kind="stable")]
        labels = [axis.data.labels[i][:8] for i in worst[:SHOWN]]
        more = f" +{len(worst) - SHOWN}" if len(worst) > SHOWN else ""
        return Cell((", ".join(labels) or "none") + more, len(worst))

    return cell
