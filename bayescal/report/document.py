"""The result document: one JSON object, as described in docs/result.md."""

from __future__ import annotations

import json
import math
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import numpy as np

import bayescal
from bayescal.comparison.defence import Prediction
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.inference.posterior import INTERVAL_PROBABILITY, ParameterSummary, Posterior
from bayescal.models.priors import TAU_BOUNDS, PriorRule
from bayescal.report.adequacy import adequacy_rows
from bayescal.report.defence import defence_document
from bayescal.report.facts import dumps as dumps
from bayescal.report.facts import points_facts
from bayescal.report.noise import evidence_document, noise_document, points_document
from bayescal.settings import Settings

PREDICTION = (
    "elpd_loo",
    "elpd_loo_se",
    "elpd_diff",
    "elpd_diff_se",
    "p_loo",
    "pareto_k_max",
    "elpd_psis",
    "elpd_psis_mcse",
    "elpd_group",
    "influential_points",
)
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
        "provenance": comparison.origin or _provenance(comparison.settings, command),
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


def _provenance(settings: Settings, command: str) -> dict[str, Any]:
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
        "bayescal": bayescal.__version__,
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
            "reference_sigma_px": None if per_point else reference.value,
            "reference": reference.source,
            "reference_dof": reference.dof,
            "scatter_px": axis.scatter[0],
            "scatter_dof": axis.scatter[1],
            **noise_document(axis),
        },
        "prior": _prior(axis.prior, axis.orders[-1].order),
        "orders": [_order(result, axis) for result in axis.orders],
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


def _prediction(found: Prediction | None) -> dict[str, Any]:
    if found is None:
        return dict.fromkeys(PREDICTION)
    k_max = None if found.pareto_k is None else _finite(float(found.pareto_k.max()))
    loo = found.loo
    values = (loo.elpd, _finite(loo.se), found.difference, _finite(found.difference_se), loo.p_eff)
    return dict(
        zip(
            PREDICTION,
            (
                *values,
                k_max,
                found.psis_elpd,
                found.psis_mcse,
                found.group_elpd,
                list(found.influential),
            ),
            strict=True,
        )
    )


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


def _order(result: OrderResult, axis: AxisComparison) -> dict[str, Any]:
    fit, good, found = result.fit, result.goodness, result.criteria
    posterior, size = result.posterior, len(fit.coefficients)
    gaussian = isinstance(posterior, Posterior)
    by_name = {p.name: p for p in result.posterior.parameters}
    chain = result.posterior.chain
    chains, draws, _ = chain.draws.shape
    best = {
        name: min((getattr(r.criteria, name) for r in axis.orders), key=_none_last)
        for name in ("aic", "aicc", "bic")
    }
    found_loo = axis.defence.prediction.get(result.order) if axis.defence is not None else None
    coefficients = []
    for j, summary in enumerate(result.posterior.parameters[:size]):
        errors = fit.standard_errors
        coefficients.append(
            {
                "name": summary.name,
                "mle": float(fit.coefficients[j]) if gaussian else None,
                "mle_se": None if errors is None or not gaussian else float(errors[j]),
                **_summary(summary),
            }
        )
    return {
        "order": result.order,
        "n_coefficients": size,
        "n_parameters": found.n_parameters,
        "rss_px2": result.rss_px2,
        "sigma_hat_px": math.sqrt(result.rss_px2 / fit.dof) if fit.dof > 0 else None,
        "chi2": good.chi2,
        "dof": good.dof,
        "chi2_reduced": good.chi2_reduced,
        "chi2_reduced_sd": good.chi2_reduced_sd,
        "p_value": good.p_value,
        "p_value_lower": good.p_value_lower,
        "f_p_value": good.f_p_value,
        "log_likelihood_max": found.log_likelihood,
        "aic": found.aic,
        "aicc": found.aicc,
        "bic": found.bic,
        **{f"delta_{n}": _difference(getattr(found, n), best[n]) for n in ("aic", "aicc", "bic")},
        "log_evidence": posterior.log_evidence,
        "log_evidence_error": posterior.log_evidence_error,
        "evidence": evidence_document(result),
        "probability": result.probability,
        **_prediction(found_loo),
        "exact_fit": fit.exact,
        "coefficients": coefficients,
        "sigma": _summary(by_name["sigma"]) if "sigma" in by_name else None,
        "scale": _summary(by_name["scale"]) if "scale" in by_name else None,
        "tau": _summary(by_name["tau"]) if "tau" in by_name else None,
        "noise_parameters": {n: _summary(by_name[n]) for n in axis.noise_model.parameters},
        "sampling": {
            "sampler": "emcee",
            "walkers": chains,
            "steps": draws,
            "draws": chains * draws,
            "acceptance": chain.acceptance,
            "autocorrelation_time": _finite(chain.autocorrelation_time),
            "converged": result.posterior.converged,
            "agrees_with_exact": posterior.agrees_with_exact
            if isinstance(posterior, Posterior)
            else None,
        },
    }


def _summary(p: ParameterSummary) -> dict[str, Any]:
    return {
        "mean": p.mean,
        "sd": p.sd,
        "interval": list(p.interval),
        "interval_probability": INTERVAL_PROBABILITY,
        "mcse_mean": _finite(p.mcse_mean),
        "ess_bulk": _finite(p.ess_bulk),
        "ess_tail": _finite(p.ess_tail),
        "rhat": _finite(p.rhat),
        "exact_mean": p.exact_mean,
        "exact_sd": p.exact_sd,
    }


def _finite(value: float) -> float | None:
    """Turn a diagnostic that could not be computed into null."""
    return value if math.isfinite(value) else None


def _none_last(value: float | None) -> tuple[bool, float]:
    return value is None, 0.0 if value is None else value


def _difference(value: float | None, best: float | None) -> float | None:
    return None if value is None or best is None else value - best
