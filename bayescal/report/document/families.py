"""The result document of a comparison across families."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from bayescal.arrays import finite
from bayescal.comparison.criteria.information import ACROSS
from bayescal.comparison.families.exact_parameters import exact_parameters
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison, FamilyDefence
from bayescal.comparison.settings import Settings
from bayescal.inference.correlation import weak_combinations
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.report.document.defence import adequacy_rows, removal_rows
from bayescal.report.document.shared import (
    covariance_facts,
    evidence_facts,
    findings_facts,
    interval_facts,
    points_facts,
    provenance,
    summary_facts,
)
from bayescal.report.numbers import correlations

SCHEMA = "bayescal.families/1"


def families_document(
    found: FamilyComparison, command: str, *, whole: bool = True
) -> dict[str, Any]:
    """Build the result document: JSON values only, null where there is nothing.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance; of what a run holds, that run's stays.
    whole : bool, optional
        With all parameters; without those in closed form it is made in a fraction of the time.
    """
    verdict = found.verdict
    return {
        "schema": SCHEMA,
        "provenance": found.origin or provenance(command, found.settings),
        "settings": settings_facts(found.request, found.settings),
        "data": points_facts(found.points),
        "report": found.points.setup.heading.facts,
        "families": {
            "radial": found.request.radial,
            "noise": dict(zip(("r", "c"), found.noise, strict=True)),
            "priors": list(found.priors),
            "models": [
                _model(m, chance, found.points.labels, whole=whole)
                for m, chance in zip(found.models, found.probabilities, strict=True)
            ],
        },
        "verdict": {
            "best": str(verdict.best),
            "plausible": [str(name) for name in verdict.plausible],
            "decided": verdict.decided,
            "findings": findings_facts(verdict.findings),
            "families": verdict.families,
            "positions": verdict.positions,
            "log_bayes_factor_to_other_family": verdict.log_bayes_factor,
            "caveats": list(verdict.caveats),
            "text": verdict.text,
        },
        "notes": list(found.notes),
        "adequacy": adequacy_rows(found.adequacy) if found.adequacy else None,
        "grouped": None if found.grouped is None else asdict(found.grouped),
        "defence": None if found.defence is None else _defence(found.defence),
    }


def _defence(found: FamilyDefence) -> dict[str, Any]:
    return {
        "group_source": found.group_source,
        "groups": found.groups,
        "points_that_matter": removal_rows(found.points_that_matter),
        "groups_that_matter": removal_rows(found.groups_that_matter),
    }


def settings_facts(request: FamilyRequest, settings: Settings) -> dict[str, Any]:
    """Collect what was asked for: which models, and how they are to be judged."""
    wanted = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(request).items()}
    return {**wanted, **asdict(settings)}


def _model(
    model: JointModel, chance: float, labels: Sequence[str], *, whole: bool
) -> dict[str, Any]:
    name, loo, goodness = model.key, model.loo, model.goodness
    k = None if loo is None else loo.largest_k
    return {
        "name": str(name),
        "family": name.family,
        "orders": list(name.orders),
        "position": name.position,
        "n_parameters": model.criteria.n_parameters,
        "log_likelihood_max": model.criteria.log_likelihood,
        **{c.key: model.criteria.values.get(c.key) for c in ACROSS},
        "chi2": None if goodness is None else goodness.chi2,
        "dof": None if goodness is None else goodness.dof,
        "chi2_p_value": None if goodness is None else goodness.p_value,
        "log_evidence": model.log_evidence,
        "log_evidence_error": model.log_evidence_error,
        "evidence_warnings": list(model.warnings),
        "probability": chance,
        "elpd_loo": None if loo is None else loo.elpd,
        "elpd_loo_se": None if loo is None else loo.se,
        "elpd_loo_mcse": None if loo is None else loo.mcse,
        "elpd_reliable": None if loo is None else loo.reliable,
        "pareto_k_max": None if k is None else finite(k),
        "pareto_k_limit": None if loo is None else loo.k_limit,
        "refitted": [] if loo is None else [labels[i] for i in loo.refitted],
        "camera_position_mle": model.position.tolist(),
        **(_parameters(model) if whole else {}),
        "sampling": None if model.posterior is None else _sampling(model.posterior),
    }


def _parameters(model: JointModel) -> dict[str, Any]:
    return {
        "covariance": covariance_facts(model),
        "closed_form": _closed_form(model) if model.exact else None,
    }


def _sampling(posterior: SampledPosterior) -> dict[str, Any]:
    draws, matrix = posterior.chain.draws, correlations(posterior)
    return {
        "sampler": "emcee",
        "walkers": draws.shape[0],
        "steps": draws.shape[1],
        "acceptance": posterior.chain.acceptance,
        "converged": posterior.converged,
        "parameters": [{"name": p.name, **summary_facts(p)} for p in posterior.parameters],
        "correlation": matrix.tolist(),
        "weakly_identified": [
            dict(zip(names, shares, strict=True))
            for names, shares in weak_combinations(posterior.names, matrix)
        ],
        "evidence": evidence_facts(posterior),
    }


def _closed_form(model: JointModel) -> list[dict[str, Any]]:
    return [
        {
            "name": p.name,
            "axis": p.axis,
            "mean": p.mean,
            "sd": p.sd,
            **interval_facts(p.interval),
        }
        for p in exact_parameters(model.exact)
    ]
