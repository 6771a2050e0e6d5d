"""The document of a comparison of lens models over many views."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from bayescal.arrays import finite
from bayescal.comparison.lenses.judging import plausible_others, widest
from bayescal.comparison.lenses.off_point import BadPoint, OffPoint
from bayescal.comparison.lenses.prediction import PROBABILITY
from bayescal.comparison.lenses.results import JudgedLens, LensComparison
from bayescal.comparison.lenses.verdict import TOLERANCE
from bayescal.points.views.views import Views
from bayescal.report.document.shared import (
    covariance_facts,
    evidence_facts,
    findings_facts,
    provenance,
    summary_facts,
)

SCHEMA = "bayescal.lenses/1"


def lenses_document(found: LensComparison, command: str, *, whole: bool = True) -> dict[str, Any]:
    """Build the result document: JSON values only, null where there is nothing.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance.
    whole : bool, optional
        With covariances, which take a while of many lenses.
    """
    return {
        "schema": SCHEMA,
        "provenance": found.origin or provenance(command, found.settings),
        "settings": {
            **asdict(found.request),
            "lenses": None if found.request.lenses is None else list(found.request.lenses),
            **{name: getattr(found.settings, name) for name in ("sigma", "seed", "ess")},
        },
        "data": _data(found),
        "report": found.views.heading.facts,
        "noise": _noise(found),
        "lenses": [_lens(judged, found, whole=whole) for judged in found.lenses],
        "impossible": list(found.impossible),
        "posterior": _posterior(found),
        "projection_sd_px": {
            "range": found.range,
            "places": [{**asdict(place), "pixel": list(place.pixel)} for place in found.places],
        },
        "gross_errors": [
            {**_place(p, found.views), "shift_px": list(p.shift), "p_value": p.p_value}
            for p in found.gross
        ],
        "bad_points": None
        if found.bad is None
        else [_bad(point, found.views) for point in found.bad.points],
        "verdict": _verdict(found),
        "notes": list(found.notes),
    }


def _data(found: LensComparison) -> dict[str, Any]:
    views, (width, height) = found.views, found.setting.data.size
    return {
        "source": views.source,
        "sha256": views.sha256,
        "n_views": len(views),
        "n_points": views.n_points,
        "views": list(views.names),
        "image": {"width_px": int(width), "height_px": int(height)},
        "target_diagonal": views.diagonal,
    }


def _noise(found: LensComparison) -> dict[str, Any]:
    setting, diagonal = found.setting, found.views.diagonal
    levels = setting.data.levels
    return {
        "kind": found.request.noise,
        "bad_fraction": None if found.bad is None else found.bad.fraction,
        "sigma_px": setting.level.sigma,
        "view_levels": None if levels is None else levels.tolist(),
        "independent": not (setting.grid.correlated or setting.grid.offsets),
        "error_models": [
            {**asdict(error), "length_target_units": error.length * diagonal, "weight": weight}
            for error, weight in found.errors
        ],
    }


def _posterior(found: LensComparison) -> dict[str, Any]:
    """Posterior of the most probable lens."""
    posterior = found.posterior
    return {
        "lens": found.best.name,
        "converged": posterior.converged,
        "acceptance": posterior.chain.acceptance,
        "parameters": [{"name": p.name, **summary_facts(p)} for p in posterior.parameters],
        "covariance": covariance_facts(found),
        "evidence": evidence_facts(posterior),
        "log_evidence_laplace": found.problem.laplace.log_evidence,
    }


def _verdict(found: LensComparison) -> dict[str, Any]:
    verdict, others = found.verdict, plausible_others(found.lenses)
    return {
        "best": verdict.best,
        "plausible": list(verdict.plausible),
        "status": verdict.status,
        "decided": verdict.decided,
        "difference_inside_px": widest([j.inside for j in others]),
        "difference_image_px": widest([j.difference for j in others]),
        "difference_inside_at_most_px": verdict.worth,
        "difference_image_at_most_px": verdict.beyond,
        "difference_probability": PROBABILITY,
        "tolerance_px": TOLERANCE,
        "findings": findings_facts(verdict.findings),
        "caveats": list(verdict.caveats),
        "text": verdict.text,
    }


def _place(point: OffPoint, views: Views) -> dict[str, Any]:
    """Say which point of which view, and where in their file."""
    return {
        "view": point.view,
        "point": point.label,
        "line": None if views.lines is None else views.lines[point.point],
    }


def _bad(point: BadPoint, views: Views) -> dict[str, Any]:
    return {
        **_place(point, views),
        "shift_px": [finite(v) for v in point.shift],
        "probability": point.probability,
        "left_out": point.left_out,
    }


def _lens(judged: JudgedLens, found: LensComparison, *, whole: bool) -> dict[str, Any]:
    estimate, lost = judged.evidence.estimate, judged.loo
    values = judged.model.report(judged.fit.x, found.setting.data.diagonal).tolist()
    return {
        "name": judged.name,
        "family": judged.candidate.family,
        "order": judged.candidate.order,
        "n_parameters": judged.n_parameters,
        "rms_px": judged.rms,
        "chi2": judged.chi2,
        "aic": judged.aic,
        "bic": judged.bic,
        "least_squares": dict(zip(judged.model.names, values, strict=True)),
        "log_evidence": judged.log_evidence,
        "log_evidence_error": finite(judged.log_evidence_error),
        **({} if judged.mixed is None else {"bad_points": len(judged.mixed.sets.places)}),
        "effective_fraction": estimate.effective_fraction,
        "pareto_k": finite(estimate.pareto_k),
        "evidence_warnings": list(estimate.warnings),
        "error_models_tried": judged.evidence.errors.tried,
        "probability": judged.probability,
        **({"covariance": covariance_facts(judged)} if whole else {}),
        "elpd_views": None if lost is None else lost.elpd,
        "elpd_views_se": None if lost is None else lost.se,
        "elpd_of_views": None if lost is None else lost.pointwise.tolist(),
        "difference_inside_px": judged.inside,
        "difference_image_px": judged.difference,
        "difference_inside_at_most_px": judged.inside_at_most,
        "difference_image_at_most_px": judged.difference_at_most,
    }
