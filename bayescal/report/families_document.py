"""The result document and the folder of a comparison across families."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

import bayescal
from bayescal.comparison.families import FamilyComparison, JointModel
from bayescal.comparison.weak import correlation, weak_combinations
from bayescal.files import RESULT, FolderKind, check_folder, write_folder
from bayescal.inference.arviz_bridge import Draws, write_netcdf
from bayescal.inference.posterior import INTERVAL_PROBABILITY
from bayescal.report.document import PACKAGES
from bayescal.report.facts import points_facts

SCHEMA = "bayescal.families/1"
DRAWS = "draws"
FOLDER = FolderKind("comparison across families", RESULT, (DRAWS,))


def families_document(found: FamilyComparison, command: str) -> dict[str, Any]:
    """Build the result document: JSON values only, null where there is nothing."""
    verdict = found.verdict
    return {
        "schema": SCHEMA,
        "provenance": {
            "bayescal": bayescal.__version__,
            "python": platform.python_version(),
            **{name: version(name) for name in PACKAGES},
            "command": command,
            "seed": found.settings.seed,
            "ess": found.settings.ess,
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        },
        "data": points_facts(found.points),
        "families": {
            "radial": found.request.radial,
            "noise": dict(zip(("r", "c"), found.noise, strict=True)),
            "priors": list(found.priors),
            "models": [
                _model(m, chance)
                for m, chance in zip(found.models, found.probabilities, strict=True)
            ],
        },
        "verdict": {
            "best": str(verdict.best),
            "plausible": [str(name) for name in verdict.plausible],
            "decided": verdict.decided,
            "families": verdict.families,
            "positions": verdict.positions,
            "log_bayes_factor_to_other_family": verdict.log_bayes_factor,
            "caveats": list(verdict.caveats),
            "text": verdict.text,
        },
        "notes": list(found.notes),
    }


def families_schema() -> dict[str, Any]:
    """JSON Schema of the document."""
    text = files("bayescal.report").joinpath("families.schema.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def _model(model: JointModel, chance: float) -> dict[str, Any]:
    posterior, name = model.posterior, model.name
    estimate = None if posterior is None else asdict(posterior.estimate)
    if estimate is not None:
        estimate["warnings"] = list(estimate["warnings"])
    sampled = None
    if posterior is not None:
        draws = posterior.chain.draws
        matrix = correlation(draws.reshape(-1, draws.shape[2]))
        sampled = {
            "sampler": "emcee",
            "walkers": draws.shape[0],
            "steps": draws.shape[1],
            "acceptance": posterior.chain.acceptance,
            "converged": posterior.converged,
            "parameters": [
                {
                    "name": p.name,
                    "mean": p.mean,
                    "sd": p.sd,
                    "interval": list(p.interval),
                    "interval_probability": INTERVAL_PROBABILITY,
                    "mcse_mean": p.mcse_mean,
                    "ess_bulk": p.ess_bulk,
                    "ess_tail": p.ess_tail,
                    "rhat": p.rhat,
                }
                for p in posterior.parameters
            ],
            "correlation": matrix.tolist(),
            "weakly_identified": [
                dict(zip(names, shares, strict=True))
                for names, shares in weak_combinations(posterior.names, matrix)
            ],
            "evidence": estimate,
        }
    return {
        "name": str(name),
        "family": name.family,
        "orders": list(name.orders),
        "position": name.position,
        "n_parameters": model.n_parameters,
        "log_likelihood_max": model.log_likelihood,
        "aic": model.aic,
        "bic": model.bic,
        "log_evidence": model.log_evidence,
        "log_evidence_error": model.log_evidence_error,
        "evidence_warnings": list(model.warnings),
        "probability": chance,
        "elpd_loo": model.elpd,
        "elpd_loo_se": model.elpd_se,
        "pareto_k_max": model.pareto_k,
        "camera_position_mle": model.position.tolist(),
        "sampling": sampled,
    }


def check_families_folder(folder: Path, *, force: bool) -> None:
    """Refuse a folder that can't be written, before any work is done."""
    check_folder(folder, FOLDER, force=force)


def write_families(folder: Path, found: FamilyComparison, text: str, *, force: bool) -> None:
    """Write the document and the draws of every sampled model, whole or not at all.

    Parameters
    ----------
    folder : Path
    found : FamilyComparison
    text : str
        The result document.
    force : bool
        Replace an earlier one.
    """

    def fill(made: Path) -> None:
        (made / RESULT).write_text(text, encoding="utf-8")
        (made / DRAWS).mkdir()
        for model in found.models:
            if model.posterior is not None:
                _write_draws(made / DRAWS, model)

    write_folder(folder, FOLDER, fill, force=force)


def _write_draws(folder: Path, model: JointModel) -> None:
    posterior = model.posterior
    assert posterior is not None, "it was sampled"
    draws = posterior.chain.draws
    file = "-".join([model.name.family, *(str(k) for k in model.name.orders), model.name.position])
    groups = {
        "posterior": {name: draws[:, :, j] for j, name in enumerate(posterior.names)},
        "sample_stats": {"lp": posterior.chain.log_prob},
    }
    described: dict[str, str | float] = {
        "model": str(model.name),
        "units": "focal, centre, sigma, coefficients px; rotation degrees; position world units",
        "inference_library": "emcee",
    }
    write_netcdf(folder / f"{file}.nc", Draws(groups, described, {}))
