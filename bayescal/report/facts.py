"""What the JSON documents share: the points' description, and the way they are written."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from bayescal.inference.posterior import INTERVAL_PROBABILITY, ParameterSummary
from bayescal.points.correspondences import Correspondences

if TYPE_CHECKING:  # Gaussian noise samples nothing of the kind
    from bayescal.inference.sampled_posterior import SampledPosterior


def dumps(found: dict[str, Any]) -> str:
    """Format a document as JSON text; refuses NaN."""
    return json.dumps(found, indent=1, allow_nan=False, ensure_ascii=True) + "\n"


def points_facts(points: Correspondences) -> dict[str, Any]:
    """Collect what a result document says of the points and the camera."""
    setup = points.setup
    return {
        "source": points.source,
        "sha256": points.sha256,
        "n_points": len(points),
        "image": {"width_px": setup.width, "height_px": setup.height},
        "camera_position": list(setup.position),
        "c_from_bottom": setup.c_from_bottom,
        "assumed": list(setup.assumed),
    }


def summary_facts(p: ParameterSummary) -> dict[str, Any]:
    """Collect what a result document says of a sampled parameter beside its name."""
    return {
        "mean": p.mean,
        "sd": p.sd,
        "interval": list(p.interval),
        "interval_probability": INTERVAL_PROBABILITY,
        "mcse_mean": finite(p.mcse_mean),
        "ess_bulk": finite(p.ess_bulk),
        "ess_tail": finite(p.ess_tail),
        "rhat": finite(p.rhat),
    }


def evidence_facts(posterior: SampledPosterior) -> dict[str, Any]:
    """Collect what tells whether to trust a sampled evidence."""
    found = asdict(posterior.estimate)
    found["warnings"] = list(found["warnings"])
    shown = {k: finite(v) if isinstance(v, float) else v for k, v in found.items()}
    return {**shown, "trusted": posterior.estimate.certain, "modes": len(posterior.modes)}


def finite(value: float) -> float | None:
    """Turn a diagnostic that could not be computed into null."""
    return value if math.isfinite(value) else None
