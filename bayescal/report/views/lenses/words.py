"""What is said of lens models over many views: noise, errors, priors, notes below tables."""

from __future__ import annotations

import math

from bayescal.calibration.judging.laplace import degrees
from bayescal.calibration.model.error_model import ErrorModel
from bayescal.comparison.lenses.results import LensComparison
from bayescal.inference.correlation import correlation, weak_lines
from bayescal.report.views.lenses.tables import SHOWN
from bayescal.rounding import counted, percent, rounded, significant

PRIORS = (
    "ln f about ln(width) sd 0.7, fy/fx sd 0.05, principal point sd 0.1 width about the middle; a "
    "coefficient by its displacement at the image's corner, N(0, (tau * width)²), tau inferred; "
    "poses uniform"
)


def about(found: LensComparison) -> list[str]:
    """Say what was analysed."""
    views, setting = found.views, found.setting
    width, height = (int(v) for v in setting.data.size)
    kind = "planar target" if setting.data.planar else "target"
    line = (
        f"{views.source}: {counted(len(views), 'view')}, {counted(views.n_points, 'point')} of a "
        f"{kind} of {counted(len(views.target), 'point')}, image {width} by {height} px"
    )
    return [line, *(f"note: {note}" for note in found.notes)]


def assumed(found: LensComparison) -> list[tuple[str, str]]:
    """Name noise, errors and priors."""
    level, factor = found.setting.level.sigma, found.views.sigma is not None
    if level is None:
        what = "a factor on the stated deviations" if factor else "one sigma"
        noise = f"Gaussian, {what} inferred, ln sigma uniform on 0.01 to 10 px"
        levels = found.setting.data.levels
        if levels is not None:
            low, high = (significant(float(v)) for v in (levels.min(), levels.max()))
            noise += f"; views of their own levels, {low} to {high} times it, from residuals"
    else:
        noise = f"Gaussian, sigma {level:g}{' times those stated' if factor else ' px'}"
    if found.bad is not None:
        noise += (
            "; or bad: each point with a probability uniform on 0 to 1 (posterior mean "
            f"{percent(found.bad.fraction)}), then anywhere in the image"
        )
    if found.setting.grid.correlated or found.setting.grid.offsets:
        errors = f"settled before a lens is judged: {error_words(found)}"
    else:
        errors = "independent, the target exact (as asked for; no real target is)"
    bow = bow_words(found)
    pairs = [("noise", noise), ("errors", errors)]
    return [*pairs, *([("bow", bow)] if bow else []), ("priors", PRIORS)]


def error_words(found: LensComparison) -> str:
    """Error models averaged, in words."""
    weights = [weight for _, weight in found.errors]
    total = math.fsum(weights)

    def share(has: str) -> float:
        return math.fsum(w for e, w in found.errors if getattr(e, has) > 0) / total

    best = found.errors[0][0]
    sigma = _sigma(found)
    parts = []
    if found.setting.grid.correlated:
        parts.append(f"{percent(share('correlated'))} that neighbours share errors")
    if found.setting.grid.offsets:
        offsets = math.fsum(w for e, w in found.errors if e.offsets) / total
        parts.append(f"{percent(offsets)} that points of the target are off")
    if not parts:
        return ""
    size = _shared_words(best, sigma)
    return f"probability {', '.join(parts)}" + (f" ({size})" if size else "")


def _shared_words(best: ErrorModel, sigma: float) -> str:
    parts = []
    if best.correlated:
        parts.append(f"shared sd {significant(sigma * best.correlated**0.5)} px")
    if best.offsets:
        size = sigma * math.hypot(best.rough, best.smooth)
        parts.append(f"offsets sd {significant(size)} px")
    return ", ".join([*parts, f"own sd {significant(sigma)} px"]) if parts else ""


def _sigma(found: LensComparison) -> float:
    problem = found.best.evidence.problem
    squares = problem.reduced.sum_of_squares
    known = problem.level.sigma
    return known if known is not None else math.sqrt(squares / degrees(problem.data))


def bow_words(found: LensComparison) -> str:
    """How much the target bows."""
    if not found.setting.bow:
        return ""
    x, y = (found.posterior[name] for name in ("bow_x", "bow_y"))
    return (
        f"of the target along x {rounded(x.mean, x.sd)} ± {significant(x.sd)}, along y "
        f"{rounded(y.mean, y.sd)} ± {significant(y.sd)} (its unit)"
    )


def columns_words() -> tuple[str, ...]:
    """Explain the columns where there is no room for more than their heads."""
    return (
        "Columns inside and image: largest difference of fitted predictions to the best lens in "
        "px, where the points are and over the whole image, at infinity, after the turn that the "
        "poses absorb; the verdict adds their uncertainty.",
        "elpd: leave-one-view-out, the pose of the view integrated; d elpd against the best, ± "
        "its paired standard error. dBIC counts poses, and takes noise as independent.",
    )


def impossible_words(found: LensComparison) -> tuple[str, ...]:
    """Say which lenses no table shows."""
    if not found.impossible:
        return ()
    return (f"Not possible, some point can't be seen: {', '.join(found.impossible)}.",)


def not_shown_words(found: LensComparison) -> tuple[str, ...]:
    """Say which lenses the first table does not show."""
    rest = ", ".join(j.name for j in found.lenses[SHOWN:])
    return (f"Less probable: {rest} (the report and --json have their numbers).",) if rest else ()


def parameters_note(found: LensComparison) -> str:
    """Say what the table of parameters is of."""
    return (
        f"{found.best.name} under its most probable error model, by emcee; fx, fy, cx, cy and "
        "sigma in px, coefficients in OpenCV's order and sign; displacements: error models "
        "averaged."
    )


def places_note(found: LensComparison) -> str:
    """Say what the table of places shows."""
    return (
        "Uncertainty of the projection in px (rms of r and c, to first order), the share of the "
        "poses taken out, error models and probable lenses averaged; range "
        f"{significant(found.range, 3)}, the "
        "target's distance. Columns jackknife and halves: the same at infinity from the spread "
        "over views; where that is clearly larger, quote it."
    )


def weak_words(found: LensComparison) -> list[str]:
    """Name what moves together, a sentence for each combination."""
    model, data = found.problem.model, found.setting.data
    matrix = correlation(model.report(found.draws, data.diagonal))
    return weak_lines(model.names, matrix)


def sampling_words(found: LensComparison) -> str:
    """Say how the draws were made."""
    chain, estimate = found.posterior.chain, found.best.evidence.estimate
    n = chain.draws.shape[0] * chain.draws.shape[1]
    return (
        f"{found.best.name}: {n} draws by emcee, acceptance {chain.acceptance:.2f}; evidence from "
        f"{estimate.draws} importance draws, {100 * estimate.effective_fraction:.0f}% effective; "
        f"seed {found.settings.seed}."
    )
