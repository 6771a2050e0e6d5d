"""A comparison under robust noise: its table, and what the result document says of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.verdict import percent
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.posterior import Posterior
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.report.facts import evidence_facts
from bayescal.report.grid import Cell, Column, Table, number_cell, order_table
from bayescal.report.noise import MARK
from bayescal.rounding import significant

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
    columns += [(HEADS[name], _mean(name)) for name in axis.noise_model.parameters]
    if isinstance(axis.noise_model, OutlierMixture):
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


HEADS = {
    "nu": Column("nu", "degrees of freedom of Student-t noise, posterior mean and sd"),
    "bad_fraction": Column("bad", "fraction of bad points, posterior mean and sd"),
    "bad_width": Column("width px", "width of the bad points, posterior mean and sd"),
    "bad_offset": Column("offset px", "offset of the bad points, posterior mean and sd"),
}


def _size(result: OrderResult) -> Cell:
    return Cell(str(len(result.fit.coefficients)), len(result.fit.coefficients))


def _rss(result: OrderResult) -> Cell:
    return Cell(f"{result.rss_px2:.1f}", result.rss_px2)


def _evidence(result: OrderResult) -> Cell:
    mark = MARK * bool(result.evidence_warnings)
    return number_cell(result.log_evidence, lambda v: f"{v:.2f}{mark}")


def error_cell(result: OrderResult) -> Cell:
    """Monte Carlo error of an evidence."""
    return number_cell(result.posterior.log_evidence_error, lambda v: significant(v, 1))


def _chance(result: OrderResult) -> Cell:
    mark = MARK * bool(result.evidence_warnings)
    return number_cell(result.probability, lambda v: percent(v) + mark)


def _mean(name: str) -> Callable[[OrderResult], Cell]:
    def cell(result: OrderResult) -> Cell:
        found = result.posterior[name]
        return Cell(f"{significant(found.mean)} ± {significant(found.sd, 1)}", found.mean)

    return cell


def _bad_points(axis: AxisComparison) -> Callable[[OrderResult], Cell]:
    def cell(result: OrderResult) -> Cell:
        found = bad_probabilities(result)
        if found is None:
            return Cell("")
        bad = np.flatnonzero(found > BAD)
        worst = bad[np.argsort(-found[bad], kind="stable")]
        labels = [axis.data.labels[i][:8] for i in worst[:SHOWN]]
        more = f" +{len(worst) - SHOWN}" if len(worst) > SHOWN else ""
        return Cell((", ".join(labels) or "none") + more, len(worst))

    return cell


def bad_probabilities(result: OrderResult) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """Posterior probability of each point to be bad; None where the noise has no notion of it."""
    posterior = result.posterior
    if isinstance(posterior, Posterior) or not isinstance(posterior.model, RobustLinearModel):
        return None
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    found = posterior.model.bad_probability(full)
    return None if found is None else np.asarray(found.mean(axis=0))


def evidence_document(result: OrderResult) -> dict[str, Any] | None:
    """Collect what tells whether to trust a sampled evidence; None for a closed form."""
    posterior = result.posterior
    return None if isinstance(posterior, Posterior) else evidence_facts(posterior)


def points_document(axis: AxisComparison) -> list[dict[str, Any]] | None:
    """Collect what robust noise says of every point at the recommended order, else None."""
    posterior = axis.chosen.posterior
    if isinstance(posterior, Posterior) or not isinstance(posterior.model, RobustLinearModel):
        return None
    full = posterior.full.reshape(-1, posterior.full.shape[2])
    bad, weight = posterior.model.bad_probability(full), posterior.model.weight(full).mean(axis=0)
    chance = [None] * len(weight) if bad is None else bad.mean(axis=0).tolist()
    return [
        {"label": label, "bad_probability": p, "weight": w}
        for label, p, w in zip(axis.data.labels, chance, weight.tolist(), strict=True)
    ]
