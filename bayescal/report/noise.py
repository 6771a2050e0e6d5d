"""Robust noise in tables and in the result document."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.console import RenderableType

from bayescal.comparison.noise_evidence import NoiseEvidence, in_words
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.comparison.verdict import percent
from bayescal.inference.posterior import Posterior
from bayescal.inference.robust_linear import RobustLinearModel
from bayescal.models.noise.outlier_mixture import OutlierMixture
from bayescal.models.noise.student_t import RATE, SHAPE, StudentT
from bayescal.report.tables import make_table
from bayescal.rounding import significant

# Beside a number whose evidence should not be trusted.
MARK = "?"


def noise_words(axis: AxisComparison) -> str:
    """Say what the noise is about its level, and its priors."""
    noise = axis.noise_model
    unit = "units of y" if axis.data.axis == "y" else "px"
    if isinstance(noise, StudentT):
        nu = f"nu = {noise.nu:g}" if noise.nu is not None else f"nu ~ Gamma({SHAPE:g}, {RATE:g})"
        return f"Student-t, {nu}; its scale sigma {axis.noise_source}"
    if isinstance(noise, OutlierMixture):
        lower, upper = noise.width_bounds
        offset = "N(0, width²)" if noise.infers_offset else "0"
        return (
            f"mixture; good points Gaussian, sigma {axis.noise_source}; bad ones wider by a width "
            f"log-uniform\n         from {lower:.4g} to {upper:.4g} {unit}, offset {offset}; their "
            f"fraction uniform from 0 to {noise.largest_fraction:g}\n        "
        )
    return f"Gaussian, sigma {axis.noise_source}"


def robust_orders_table(axis: AxisComparison) -> RenderableType:
    """One row per order under robust noise; the recommended one is marked."""
    level = axis.noise.parameter
    columns: list[tuple[str, Callable[[OrderResult], str]]] = [
        ("order", lambda r: str(r.order)),
        ("p", lambda r: str(len(r.fit.coefficients))),
        ("RSS px²", lambda r: f"{r.rss_px2:.1f}"),
    ]
    if axis.noise.value is None:
        columns.append((level, lambda r: _mean(r, level)))
    columns += [(_head(n), _column(n)) for n in axis.noise_model.parameters]
    if isinstance(axis.noise_model, OutlierMixture):
        columns.append(("bad points", _bad_points))
    columns += [
        ("ln Z", lambda r: f"{r.log_evidence or 0.0:.2f}{MARK * bool(r.evidence_warnings)}"),
        ("MC error", lambda r: significant(r.posterior.log_evidence_error or 0.0, 1)),
        ("prob.", lambda r: percent(r.probability or 0.0) + MARK * bool(r.evidence_warnings)),
    ]
    chosen = [r.order == axis.verdict.order for r in axis.orders]
    rows = [
        [">" if mark else "", *(value(r) for _, value in columns)]
        for mark, r in zip(chosen, axis.orders, strict=True)
    ]
    bold = chosen.index(True) if any(chosen) else None
    return make_table(["", *(head for head, _ in columns)], rows, bold=bold, spare=("RSS px²",))


def robust_footnotes(axis: AxisComparison) -> list[str]:
    """Say what the table of `robust_orders_table` does not."""
    lines = [
        "RSS is of least squares, for comparison. Chi-squared, F tests, AIC and BIC belong to "
        "Gaussian noise.",
        "ln Z by importance sampling, checked by bridge sampling; the other columns are posterior "
        "means (± sd).",
    ]
    if isinstance(axis.noise_model, OutlierMixture):
        lines.append("bad points: labels of those more probably bad than good.")
    if any(r.evidence_warnings for r in axis.orders):
        lines.append(f"{MARK} an evidence that should not be trusted; the caveats say why.")
    return lines


def _head(name: str) -> str:
    return {"bad_fraction": "bad", "bad_width": "width px", "bad_offset": "offset px"}.get(
        name, name
    )


def _column(name: str) -> Callable[[OrderResult], str]:
    return lambda r: _mean(r, name)


def _mean(result: OrderResult, name: str) -> str:
    found = result.posterior[name]
    return f"{significant(found.mean)} ± {significant(found.sd, 1)}"


def _bad_points(result: OrderResult) -> str:
    """Labels of the bad points, few of them."""
    found = bad_probabilities(result)
    if found is None:
        return ""
    bad = np.flatnonzero(found > 0.5)
    worst = bad[np.argsort(-found[bad], kind="stable")]
    shown = ", ".join(str(i + 1) for i in worst[:4])
    return shown + (f" +{len(worst) - 4}" if len(worst) > 4 else "") or "none"


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


def noises_table(axis: AxisComparison, noises: tuple[NoiseEvidence, ...]) -> RenderableType:
    """Log evidence of the recommended order under every noise model."""
    chosen = axis.chosen
    own = chosen.log_evidence or 0.0
    rows = [[f"   {in_words(axis.noise_model.name)}, as compared", f"{own:.2f}", "", ""]]
    for found in noises:
        mark = MARK * bool(found.warnings)
        rows.append(
            [
                f"   {in_words(found.name)}",
                f"{found.total:.2f}{mark}",
                significant(found.total_error, 1) if found.total_error else "",
                f"{found.total - own:+.2f}{mark}",
            ]
        )
    heads = [f"   noise, at order {chosen.order}", "ln Z", "MC error", "ln B"]
    return make_table(heads, rows)
