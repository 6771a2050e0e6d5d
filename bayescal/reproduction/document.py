"""The document of a reproduction: one JSON object, as described in docs/result.md."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from bayescal.arrays import finite
from bayescal.comparison.criteria.information import CRITERIA
from bayescal.report.document.shared import points_facts, provenance
from bayescal.reproduction.results import (
    AxisReproduction,
    OrderReproduction,
    Reproduction,
    ThesisFit,
)

SCHEMA = "bayescal.reproduction/1"
PACKAGES = ("numpy", "scipy", "matplotlib")


def reproduction_document(reproduction: Reproduction, command: str) -> dict[str, Any]:
    """Build the document of a reproduction.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance.

    Returns
    -------
    dict
        JSON values only: what is unavailable is None, never NaN. Points go by number,
        from 1.
    """
    rule = reproduction.rule
    return {
        "schema": SCHEMA,
        "provenance": provenance(command, packages=PACKAGES),
        "data": points_facts(reproduction.points),
        "labels": list(reproduction.points.labels),
        "rule": {
            "significance": rule.significance,
            "kind": "per-point" if rule.per_point else "family-wise",
            "sigma": "inferred" if rule.sigma is None else "known",
            "sigma_px": rule.sigma,
            "common": reproduction.common,
        },
        **{
            variant.replace("-", "_"): {
                axis: [_order(result) for result in found.orders] for axis, found in axes.items()
            }
            for variant, axes in reproduction.variants.items()
        },
        "after_elimination": {
            variant.replace("-", "_"): {axis: _after(found) for axis, found in axes.items()}
            for variant, axes in reproduction.variants.items()
        },
        "warnings": list(reproduction.warnings),
    }


def _order(result: OrderReproduction) -> dict[str, Any]:
    model, tests, rejection = result.before.model, result.tests, result.rejection
    n, rule = len(result.before.residuals), rejection.rule
    return {
        "order": result.order,
        "monomials": list(model.monomials),
        "names": list(model.coefficients),
        **_fit(result.before),
        "standardised": None if tests is None else _numbers(tests.standardised),
        "p_values": None if tests is None else _numbers(tests.p_values),
        "thresholds": None
        if tests is None
        else {
            "per_point": tests.threshold(rule.significance),
            "family_wise": tests.threshold(rule.significance / n),
        },
        "elimination": {
            "steps": [
                {
                    "point": step.point + 1,
                    "residual": step.residual,
                    "statistic": finite(step.statistic),
                    "p_value": step.p_value,
                    "level": step.level,
                    "n_points": step.n_points,
                }
                for step in rejection.steps
            ],
            "kept": (rejection.kept + 1).tolist(),
            "stopped": rejection.stopped,
            "after": _fit(result.after),
        },
        "common": None if result.common is None else _fit(result.common),
    }


def _fit(fit: ThesisFit) -> dict[str, Any]:
    found = fit.criteria
    return {
        "n": len(fit.kept),
        "coefficients": fit.fit.coefficients.tolist(),
        "residuals": fit.residuals.tolist(),
        "squared_errors": fit.squared_errors.tolist(),
        "rss": fit.rss,
        "rms": fit.rms,
        "rms_left_out": fit.fit.rms_left_out,
        "dof": fit.fit.dof,
        "n_parameters": found.n_parameters,
        "log_likelihood_max": found.log_likelihood,
        **{c.key: found.values.get(c.key) for c in CRITERIA},
        "exact_fit": fit.fit.exact,
    }


def _after(found: AxisReproduction) -> dict[str, Any]:
    best = found.best_on_common
    return {
        "orders_on_same_points": found.same_points,
        "common_kept": (found.common_kept + 1).tolist(),
        "lowest_bic_on_common": None if best is None else best.order,
    }


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [finite(float(value)) for value in values]
