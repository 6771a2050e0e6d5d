"""Pinholes under robust noise, sampled with several seeds: how well, and how surely."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import bayescal as bc
from bayescal.comparison.families.models import fitted_pinhole, noise_levels, robust_pinhole
from bayescal.comparison.settings import Settings
from bayescal.density.pinholes.robust import RobustPinhole
from bayescal.inference.sampled_posterior import SampledPosterior, sample_model
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import AXES
from scripts.validation.turned_camera import turned_points

SEEDS = 10
ESS = 400
NOISES = ("student-t", "outlier-mixture")
BAD = 0.05  # of the turned camera's pixel values, by up to so many px
FAR = 20.0


def robust(_: int) -> Iterator[str]:
    """Measure acceptance, effective samples a draw, R-hat and evidence over seeds."""
    yield from (
        f"{SEEDS} seeds each, `--ess {ESS}`; the turned camera is like Tsai's, of 300 points, "
        f"{100 * BAD:g} % of its values off by up to {FAR:g} px. Errors are those stated.",
        "",
        "| pinhole, noise | ln evidence, sd over seeds | largest error | acceptance "
        "| effective samples a draw | R-hat at most | sound |",
        "|" + "---|" * 7,
    )
    cases = [("thesis", bc.thesis(), order) for order in (0, 1)]
    cases.append(("turned camera", with_gross_errors(turned_points(0.1)), 1))
    for name, points, order in cases:
        for noise in NOISES:
            model = robust_model(points, order, noise)
            found = [sample_model(model, np.random.default_rng(s), ESS) for s in range(SEEDS)]
            yield f"| {name}, order {order}, {noise} | {_row(found)} |"


def robust_model(points: Correspondences, order: int, noise: str) -> RobustPinhole:
    """Build a pinhole at a free position as `compare` does."""
    settings = Settings(noise=noise, ess=ESS)
    levels = noise_levels(points, settings, order)
    fitted = fitted_pinhole(points, order, "free", "even", levels.data, settings)
    return robust_pinhole(fitted, settings.choice.model(1.0))


def with_gross_errors(points: Correspondences) -> Correspondences:
    """Move some pixel values."""
    rng = np.random.default_rng(0)
    pixels = np.column_stack([points.pixel(axis) for axis in AXES])
    bad = rng.random(pixels.shape) < BAD
    pixels[bad] += rng.uniform(-FAR, FAR, int(bad.sum()))
    return bc.Correspondences.from_arrays(points.world, pixels, setup=points.setup)


def _row(found: list[SampledPosterior]) -> str:
    logs = np.array([f.log_evidence for f in found])
    accepted = [f.chain.acceptance for f in found]
    each = [
        min(d.ess_bulk for d in f.chain.diagnostics) / f.chain.draws[:, :, 0].size for f in found
    ]
    worst = max(d.rhat for f in found for d in f.chain.diagnostics)
    error = max(f.log_evidence_error for f in found)
    sound = sum(f.converged and f.estimate.certain for f in found)
    return (
        f"{logs.mean():.3f}, {logs.std(ddof=1):.3f} | {error:.3f} "
        f"| {min(accepted):.2f}-{max(accepted):.2f} | {min(each):.2f}-{max(each):.2f} "
        f"| {worst:.4f} | {sound} of {len(found)}"
    )
