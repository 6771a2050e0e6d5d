"""Robust noise in tables and in the result document."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from bayescal.comparison.noise_evidence import NoiseEvidence, in_words, named
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.verdict import percent
from bayescal.inference.posterior import Posterior
from bayescal.inference.robust_linear import RobustLinearModel
from bayescal.models.noise.model import NoiseModel
from bayescal.models.noise.outlier_mixture import OutlierMixture
from bayescal.models.noise.student_t import RATE, SHAPE, StudentT
from bayescal.report.grid import Cell, Column, Table, number_cell, order_table
from bayescal.rounding import significant

# Beside a number whose evidence should not be trusted.
MARK = "?"
# A point is shown as bad above this probability, and so many of them.
BAD, SHOWN = 0.5, 4
NU_PRIOR = f"~ Gamma(shape {SHAPE:g}, rate {RATE:g})"


def noise_kind(axis: AxisComparison) -> str:
    """Say what the noise is about its level, its priors, and where its level comes from."""
    words, level = _shape_words(axis.noise_model, axis), axis.noise_source
    own = "its scale " if isinstance(axis.noise_model, StudentT) else ""
    return f"{words}{';' if axis.noise_model.parameters or own else ','} {own}sigma {level}"


def other_noise_lines(axis: AxisComparison, noises: tuple[NoiseEvidence, ...]) -> list[str]:
    """Say under which priors the other noise models were judged."""
    words = "; ".join(_shape_words(named(found.name, axis.data), axis) for found in noises)
    return [f"Other noise: {words}. Coefficients and sigma have the priors above."]


def _shape_words(noise: NoiseModel, axis: AxisComparison) -> str:
    unit = "units of y" if axis.data.axis == "y" else "px"
    if isinstance(noise, StudentT):
        return f"Student-t, nu {NU_PRIOR if noise.nu is None else f'= {noise.nu:g}'}"
    if isinstance(noise, OutlierMixture):
        lower, upper = noise.width_bounds
        offset = "of an offset ~ N(0, width²)" if noise.infers_offset else "without offset"
        return (
            f"mixture of good points and bad ones, whose fraction is uniform from 0 to "
            f"{noise.largest_fraction:g} and which are wider by a width, log-uniform from "
            f"{lower:.4g} to {upper:.4g} {unit}, {offset}"
        )
    return "Gaussian"


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
        (Column("MC error", "Monte Carlo standard error of ln Z, nat"), _error),
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


def robust_footnotes(axis: AxisComparison) -> list[str]:
    """Say what the table of `robust_orders_table` does not."""
    lines = [
        "RSS is of least squares, for comparison: chi-squared, F tests, AIC and BIC belong to "
        "Gaussian noise. ln Z by importance sampling, checked by bridge sampling; the other "
        "columns are posterior means ± sd.",
    ]
    if isinstance(axis.noise_model, OutlierMixture):
        lines.append("Bad points: more probably bad than good, the worst first.")
    if any(r.evidence_warnings for r in axis.orders):
        lines.append(f"{MARK} marks an evidence that should not be trusted; the caveats say why.")
    return lines


def _size(result: OrderResult) -> Cell:
    return Cell(str(len(result.fit.coefficients)), len(result.fit.coefficients))


def _rss(result: OrderResult) -> Cell:
    return Cell(f"{result.rss_px2:.1f}", result.rss_px2)


def _evidence(result: OrderResult) -> Cell:
    mark = MARK * bool(result.evidence_warnings)
    return number_cell(result.log_evidence, lambda v: f"{v:.2f}{mark}")


def _error(result: OrderResult) -> Cell:
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


def noise_document(axis: AxisComparison) -> dict[str, Any]:
    """Options and priors of the noise model, for the result document."""
    noise = axis.noise_model
    if isinstance(noise, StudentT):
        prior = {"kind": "gamma", "shape": SHAPE, "rate": RATE}
        return {"nu": {"kind": "fixed", "value": noise.nu} if noise.nu is not None else prior}
    if isinstance(noise, OutlierMixture):
        return {
            "bad_fraction_bounds": [0.0, noise.largest_fraction],
            "bad_width_bounds_px": list(noise.width_bounds),
            "bad_offset": "inferred" if noise.infers_offset else "zero",
        }
    return {}


def evidence_document(result: OrderResult) -> dict[str, Any] | None:
    """Collect what tells whether to trust a sampled evidence; None for a closed form."""
    posterior = result.posterior
    if isinstance(posterior, Posterior):
        return None
    found = asdict(posterior.estimate)
    found["warnings"] = list(found["warnings"])
    finite = {
        key: None if isinstance(value, float) and not np.isfinite(value) else value
        for key, value in found.items()
    }
    return {**finite, "trusted": posterior.estimate.certain, "modes": len(posterior.modes)}


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


def noises_document(noises: tuple[NoiseEvidence, ...]) -> list[dict[str, Any]]:
    """Evidence under other noise models, for the result document."""
    return [
        {
            "noise": found.name,
            "log_evidence": {str(k): v for k, v in found.log_evidence.items()},
            "log_evidence_error": {str(k): v for k, v in found.error.items()},
            "warnings": {str(k): list(v) for k, v in found.warnings.items()},
        }
        for found in noises
    ]


def noises_from(rows: list[dict[str, Any]]) -> tuple[NoiseEvidence, ...]:
    """Undo `noises_document`; the posteriors are not kept."""
    return tuple(
        NoiseEvidence(
            row["noise"],
            {int(k): v for k, v in row["log_evidence"].items()},
            {int(k): v for k, v in row["log_evidence_error"].items()},
            {int(k): tuple(v) for k, v in row["warnings"].items()},
            {},
        )
        for row in rows
    )


def noises_table(axis: AxisComparison, noises: tuple[NoiseEvidence, ...]) -> Table:
    """Log evidence of the recommended order under every noise model."""
    chosen = axis.chosen
    own = chosen.log_evidence or 0.0
    rows = [
        (
            Cell(f"{in_words(axis.noise_model.name)}, as compared"),
            Cell(f"{own:.2f}{MARK * bool(chosen.evidence_warnings)}", own),
            Cell("") if isinstance(chosen.posterior, Posterior) else _error(chosen),
            Cell(""),
        )
    ]
    for found in noises:
        mark = MARK * bool(found.warnings)
        rows.append(
            (
                Cell(in_words(found.name)),
                Cell(f"{found.total:.2f}{mark}", found.total),
                number_cell(found.total_error or None, lambda v: significant(v, 1)),
                Cell(f"{found.total - own:+.2f}{mark}", found.total - own),
            )
        )
    columns = (
        Column(f"noise, at order {chosen.order}"),
        Column("ln Z", "natural logarithm of the evidence"),
        Column("MC error", "Monte Carlo standard error of ln Z, nat"),
        Column("ln B", "against the noise compared with"),
    )
    return Table(columns, tuple(rows))
