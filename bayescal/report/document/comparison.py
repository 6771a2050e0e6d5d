"""The document of a comparison of orders, as described in docs/result.md."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from bayescal.comparison.orders.averaging import AveragedPrediction
from bayescal.comparison.orders.sufficiency import Sufficiency
from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.points.heading import SILENT, Heading
from bayescal.prior.amplitudes import PriorRule
from bayescal.report.document.defence import adequacy_rows, defence_document
from bayescal.report.document.order import order_document
from bayescal.report.document.shared import (
    by_order,
    findings_facts,
    points_facts,
    provenance,
)
from bayescal.report.numbers import point_chances

SCHEMA = "bayescal.comparison/1"
# Points of robust noise that are listed, at most.
SHOWN = 5000


def comparison_document(comparison: Comparison, command: str) -> dict[str, Any]:
    """Build the result document of a comparison.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance. A comparison that a run holds keeps the
        provenance of that run.

    Returns
    -------
    dict
        JSON values only: what is unavailable is None, never NaN.
    """
    axes = {name: _axis(axis) for name, axis in comparison.axes.items()}
    return {
        "schema": SCHEMA,
        "provenance": comparison.origin or provenance(command, comparison.settings),
        "settings": asdict(comparison.settings),
        "data": _data(comparison),
        "report": _heading(comparison).facts,
        "family": comparison.family,
        "axes": axes,
        "verdict": {
            "orders": comparison.orders,
            "text": " ".join(f"{n}: {a.verdict.text}" for n, a in comparison.axes.items()),
            "joint": _joint(comparison),
        },
        "notes": list(comparison.notes),
        **({} if comparison.hint is None else {"families": {"hint": comparison.hint}}),
    }


def _heading(comparison: Comparison) -> Heading:
    return SILENT if comparison.points is None else comparison.points.setup.heading


def _joint(comparison: Comparison) -> dict[str, Any] | None:
    """Probability of every pair of orders of two independent axes."""
    chances = {
        name: [r.probability for r in axis.orders if r.probability is not None]
        for name, axis in comparison.axes.items()
    }
    if len(chances) != 2 or not all(chances.values()):
        return None
    orders = {name: [r.order for r in axis.orders] for name, axis in comparison.axes.items()}
    first, second = chances.values()
    return {"orders": orders, "probability": np.outer(first, second).tolist()}


def _data(comparison: Comparison) -> dict[str, Any]:
    points = comparison.points
    if points is None:
        n = len(next(iter(comparison.axes.values())).data)
        return {
            "source": "arrays",
            "sha256": None,
            "n_points": n,
            "image": {"width_px": None, "height_px": None},
            "camera_position": None,
        }
    return points_facts(points)


def _axis(axis: AxisComparison) -> dict[str, Any]:
    verdict, domain = axis.verdict, axis.data.domain
    return {
        "regressor": axis.data.regressor,
        "n": axis.data.n,
        "domain": [domain.lower, domain.upper],
        "noise": _noise(axis),
        "prior": _prior(axis.prior, axis.orders[-1].order),
        "orders": [order_document(result, axis) for result in axis.orders],
        "points": _points(axis),
        "verdict": {
            "order": verdict.order,
            "plausible": list(verdict.plausible),
            "outcome": verdict.outcome,
            "decided": verdict.decided,
            "suffices": None if verdict.enough is None else sufficiency_document(verdict.enough),
            "findings": findings_facts(verdict.findings),
            "log_bayes_factor_to_next": verdict.log_bayes_factor_to_next,
            "strength": verdict.strength,
            "aicc_order": verdict.aicc_order,
            "bic_order": verdict.bic_order,
            "caveats": list(verdict.caveats),
            "text": verdict.text,
        },
        "averaged": None if axis.averaged is None else _averaged(axis.averaged),
        "defence": None if axis.defence is None else defence_document(axis.defence),
        "world_units": [asdict(u) for u in axis.world_units] or None,
        "adequacy": adequacy_rows(axis.adequacy) if axis.adequacy else None,
    }


def _averaged(found: AveragedPrediction) -> dict[str, Any]:
    """Predictions under the one order and averaged over orders, at places of the domain."""
    return {
        "order": found.order,
        "weights": by_order(found.weights),
        "at": found.x.tolist(),
        "chosen_px": found.chosen.tolist(),
        "chosen_sd_px": found.chosen_sd.tolist(),
        "mean_px": found.mean.tolist(),
        "sd_px": found.sd.tolist(),
        "between_px": found.between.tolist(),
    }


def sufficiency_document(enough: Sufficiency) -> dict[str, Any]:
    """How far the plausible orders lie from the recommended one."""
    return {
        "enough": enough.enough,
        "tolerance_px": enough.tolerance,
        "tolerance_stated": enough.stated,
        "largest_px": enough.largest,
        "differences": [{"order": d.order, "largest_px": d.largest} for d in enough.differences],
    }


def _noise(axis: AxisComparison) -> dict[str, Any]:
    """Noise model and level, with their priors."""
    level, reference, per_point = axis.noise, axis.reference, axis.data.sd is not None
    bounds = None if level.bounds is None else list(level.bounds)
    return {
        "kind": axis.noise_model.name,
        "sigma": level.source,
        "sigma_px": None if per_point else level.value,
        "per_point": per_point,
        "sigma_bounds_px": bounds if level.source == "inferred" else None,
        "scale_bounds": bounds if level.source == "scale" else None,
        "sigma_prior_mass": level.mass,
        "reference_sigma_px": None if per_point else reference.value,
        "reference": reference.source,
        "reference_dof": reference.dof,
        "scatter_px": axis.scatter[0],
        "scatter_dof": axis.scatter[1],
        **axis.noise_model.priors,
    }


def _points(axis: AxisComparison) -> list[dict[str, Any]] | None:
    """Give what robust noise says of every point at the recommended order.

    Of many points those that it trusts least, in the points' order.
    """
    found = point_chances(axis.chosen)
    if found is None:
        return None
    weight, bad, labels = found.weight, found.bad, axis.data.labels
    kept = np.sort(np.argsort(weight, kind="stable")[:SHOWN]).tolist()
    return [
        {
            "label": labels[i],
            "bad_probability": None if bad is None else float(bad[i]),
            "weight": float(weight[i]),
        }
        for i in kept
    ]


def _prior(rule: PriorRule, order: int) -> dict[str, Any]:
    prior = rule.of_order(order)
    tau: dict[str, Any] | None = None
    if rule.scaled:
        inferred = {"kind": "log-uniform", "bounds": list(rule.tau_bounds)}
        tau = inferred if rule.tau is None else {"kind": "fixed", "value": rule.tau}
    flat = not prior.proper
    return {
        "name": rule.name,
        "basis": "legendre",
        "size_px": rule.size,
        "mean_px": None if flat else prior.mean.tolist(),
        "sd_px": None
        if flat
        else [
            None if scaled else sd
            for scaled, sd in zip(prior.scaled, prior.sd.tolist(), strict=True)
        ],
        "tau": tau,
    }
