"""The document of an analysis of bad points."""

from __future__ import annotations

from typing import Any

from bayescal.comparison.outliers.records import PointRecord
from bayescal.comparison.outliers.results import AxisOutliers, OutlierStudy
from bayescal.comparison.outliers.shared_errors import SharedError
from bayescal.comparison.outliers.treatments import Treatment
from bayescal.report.document.shared import (
    by_order,
    findings_facts,
    points_facts,
    provenance,
)

SCHEMA = "bayescal.outliers/1"


def outliers_document(study: OutlierStudy, command: str) -> dict[str, Any]:
    """Build the result document of an analysis of bad points.

    Parameters
    ----------
    command : str
        How it was asked for, for the provenance.

    Returns
    -------
    dict
        JSON values only.
    """
    return {
        "schema": SCHEMA,
        "provenance": study.origin or provenance(command, study.settings),
        "data": points_facts(study.points),
        "report": study.points.setup.heading.facts,
        "significance": study.significance,
        "settings": _settings(study),
        "axes": {name: _axis_document(axis) for name, axis in study.axes.items()},
    }


def _settings(study: OutlierStudy) -> dict[str, Any]:
    asked, (heavy, mixture) = study.settings, study.noises
    return {
        "sigma": asked.sigma,
        "prior": asked.prior,
        "tau": asked.tau,
        "seed": asked.seed,
        "ess": asked.ess,
        "nu": heavy.nu,
        "bad_offset": mixture.infers_offset,
    }


def _axis_document(axis: AxisOutliers) -> dict[str, Any]:
    return {
        "regressor": axis.data.regressor,
        "order": axis.order,
        "sigma": axis.level.source,
        "points": [_point(p) for p in axis.points],
        "findings": findings_facts(axis.findings),
        "explanations": list(axis.explanations),
        "shared": [_shared(s) for s in axis.shared],
        "treatments": [_treatment(t, len(axis.data)) for t in axis.treatments],
        "verdict": axis.verdict,
    }


def _point(p: PointRecord) -> dict[str, Any]:
    return {
        "label": p.label,
        "number": p.index + 1,
        "measured_px": p.measured,
        "predicted_px": p.predicted,
        "predicted_sd_px": p.predicted_sd,
        "residual_px": p.residual,
        "standardised": p.standardised,
        "leverage": p.leverage,
        "cook": p.cook,
        "rejected_at": list(p.rejected_at),
        "bad_probability": p.bad_probability,
        "weight": p.weight,
        "order_without": p.order_without,
        "log_bayes_factor_without": p.log_bayes_factor_without,
    }


def _shared(s: SharedError) -> dict[str, Any]:
    return {
        "points": list(s.points),
        "good": list(s.good),
        "coordinates": s.coordinates,
        "error_px": s.error,
        "spread_px": s.spread,
        "together": s.together,
        "explained_by": s.explained_by,
    }


def _treatment(t: Treatment, n: int) -> dict[str, Any]:
    """Orders under one treatment of the points; evidences are comparable where it has all `n`."""
    return {
        "name": t.name,
        "noise": t.noise,
        "n_points": t.n_points,
        "log_evidence": by_order(t.log_evidence),
        "log_evidence_error": {j.key.order: j.log_evidence_error for j in t.orders},
        "probability": by_order(t.probability),
        "order": t.order,
        "log_evidence_all_orders": t.total if t.n_points == n else None,
        "warnings": by_order(t.warnings),
        "not_converged": [found.order for found in t.sampled if not found.posterior.converged],
    }
