"""The result document: one JSON object, as described in docs/result.md."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import numpy as np

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.comparison.settings import Settings
from bayescal.prior.amplitudes import TAU_BOUNDS, PriorRule
from bayescal.report.adequacy import adequacy_rows
from bayescal.report.defence import defence_document
from bayescal.report.facts import dumps as dumps
from bayescal.report.facts import points_facts
from bayescal.report.noise import noise_document
from bayescal.report.order import order_document
from bayescal.report.robust import points_document
from bayescal.version import __version__

SCHEMA = "bayescal.comparison/1"
PACKAGES = ("emcee", "numpy", "scipy", "arviz")


def document(comparison: Comparison, command: str) -> dict[str, Any]:
    """Build the result document of a comparison.

    Parameters
    ----------
    comparison : Comparison
    command : str
        How it was asked for, for the provenance. A comparison that a run holds keeps the
        provenance of that run.

    Returns
    -------
    dict
        JSON values only: what can't be had is None, never NaN.
    """
    axes = {name: _axis(axis) for name, axis in comparison.axes.items()}
    return {
        "schema": SCHEMA,
        "provenance": comparison.origin or provenance(comparison.settings, command),
        "settings": asdict(comparison.settings),
        "data": _data(comparison),
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


def provenance(settings: Settings, command: str) -> dict[str, Any]:
    """Say how, by what and when a document was made."""
    return {
        **versions(),
        "command": command,
        "seed": settings.seed,
        "ess": settings.ess,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def versions() -> dict[str, str]:
    """Versions of this program, of Python and of what the numbers depend on."""
    return {
        "bayescal": __version__,
        "python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
    }


def schema() -> dict[str, Any]:
    """JSON Schema of the result document."""
    text = files("bayescal.report").joinpath("result.schema.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


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
    verdict, noise, reference = axis.verdict, axis.noise, axis.reference
    domain = axis.data.domain
    per_point = axis.data.sd is not None
    bounds = None if noise.bounds is None else list(noise.bounds)
    return {
        "regressor": axis.data.regressor,
        "n": len(axis.data),
        "domain": [domain.lower, domain.upper],
        "noise": {
            "kind": axis.noise_model.name,
            "sigma": noise.source,
            "sigma_px": None if per_point else noise.value,
            "per_point": per_point,
            "sigma_bounds_px": bounds if noise.source == "inferred" else None,
            "scale_bounds": bounds if noise.source == "scale" else None,
            "sigma_prior_mass": noise.mass,
            "reference_sigma_px": None if per_point else reference.value,
            "reference": reference.source,
            "reference_dof": reference.dof,
            "scatter_px": axis.scatter[0],
            "scatter_dof": axis.scatter[1],
            **noise_document(axis),
        },
        "prior": _prior(axis.prior, axis.orders[-1].order),
        "orders": [order_document(result, axis) for result in axis.orders],
        "points": points_document(axis),
        "verdict": {
            "order": verdict.order,
            "plausible": list(verdict.plausible),
            "decided": verdict.decided,
            "log_bayes_factor_to_next": verdict.log_bayes_factor_to_next,
            "strength": verdict.strength,
            "aicc_order": verdict.aicc_order,
            "bic_order": verdict.bic_order,
            "caveats": list(verdict.caveats),
            "text": verdict.text,
        },
        "defence": None if axis.defence is None else defence_document(axis.defence),
        "world_units": [asdict(u) for u in axis.world_units] or None,
        "adequacy": adequacy_rows(axis.adequacy) if axis.adequacy else None,
    }


def _prior(rule: PriorRule, order: int) -> dict[str, Any]:
    prior = rule.of_order(order)
    tau: dict[str, Any] | None = None
    if rule.name == "field":
        inferred = {"kind": "log-uniform", "bounds": list(TAU_BOUNDS)}
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
