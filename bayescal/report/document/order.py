"""One order of an axis, in the result document."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from bayescal.arrays import finite
from bayescal.comparison.criteria.information import CRITERIA
from bayescal.comparison.results import AxisComparison, OrderResult
from bayescal.inference.posterior import ParameterSummary, Posterior
from bayescal.report.document.shared import covariance_facts, evidence_facts, summary_facts

if TYPE_CHECKING:  # a comparison without a defence does not pay for it
    from bayescal.comparison.defence.results import Prediction

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


def order_document(result: OrderResult, axis: AxisComparison) -> dict[str, Any]:
    """Build what the document holds of an order.

    Parameters
    ----------
    axis : AxisComparison
        Of which it is one: differences are from its smallest criteria.
    """
    fit, good, found = result.fit, result.goodness, result.criteria
    posterior = result.posterior
    by_name = {p.name: p for p in posterior.parameters}
    best = {
        c.key: min((r.criteria.values.get(c.key) for r in axis.orders), key=_none_last)
        for c in CRITERIA
    }
    found_loo = axis.defence.prediction.get(result.order) if axis.defence is not None else None
    return {
        "order": result.order,
        "n_coefficients": len(fit.coefficients),
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
        **{c.key: found.values.get(c.key) for c in CRITERIA},
        **{f"delta_{key}": _difference(found.values.get(key), best[key]) for key in best},
        "log_evidence": posterior.log_evidence,
        "log_evidence_error": posterior.log_evidence_error,
        "evidence": evidence_facts(posterior),
        "probability": result.probability,
        **_prediction(found_loo),
        "exact_fit": fit.exact,
        "coefficients": _coefficients(result),
        "sigma": _summary(by_name["sigma"]) if "sigma" in by_name else None,
        "scale": _summary(by_name["scale"]) if "scale" in by_name else None,
        "tau": _summary(by_name["tau"]) if "tau" in by_name else None,
        "noise_parameters": {n: _summary(by_name[n]) for n in axis.noise_model.parameters},
        "covariance": covariance_facts(result),
        "sampling": _sampling(posterior),
    }


def _coefficients(result: OrderResult) -> list[dict[str, Any]]:
    """Summaries of the coefficients; of Gaussian noise the least squares beside them."""
    fit, posterior = result.fit, result.posterior
    gaussian, errors = posterior.exact is not None, fit.standard_errors
    return [
        {
            "name": summary.name,
            "mle": float(fit.coefficients[j]) if gaussian else None,
            "mle_se": None if errors is None or not gaussian else float(errors[j]),
            **_summary(summary),
        }
        for j, summary in enumerate(posterior.parameters[: len(fit.coefficients)])
    ]


def _sampling(posterior: Posterior) -> dict[str, Any]:
    chain = posterior.chain
    chains, draws, _ = chain.draws.shape
    return {
        "sampler": "emcee",
        "walkers": chains,
        "steps": draws,
        "draws": chains * draws,
        "acceptance": chain.acceptance,
        "autocorrelation_time": finite(chain.autocorrelation_time),
        "converged": posterior.converged,
        "agrees_with_exact": posterior.agrees_with_exact,
    }


def _prediction(found: Prediction | None) -> dict[str, Any]:
    if found is None:
        return dict.fromkeys(PREDICTION)
    loo, psis = found.loo, found.psis
    k_max = None if psis is None or psis.largest_k is None else finite(psis.largest_k)
    values = (loo.elpd, finite(loo.se), found.difference, finite(found.difference_se), loo.p_eff)
    return dict(
        zip(
            PREDICTION,
            (
                *values,
                k_max,
                None if psis is None else psis.elpd,
                None if psis is None else psis.mcse,
                found.group_elpd,
                list(found.influential),
            ),
            strict=True,
        )
    )


def _summary(p: ParameterSummary) -> dict[str, Any]:
    return {**summary_facts(p), "exact_mean": p.exact_mean, "exact_sd": p.exact_sd}


def _none_last(value: float | None) -> tuple[bool, float]:
    return value is None, 0.0 if value is None else value


def _difference(value: float | None, best: float | None) -> float | None:
    return None if value is None or best is None else value - best
