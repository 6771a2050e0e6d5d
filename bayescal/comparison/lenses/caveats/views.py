"""What the views themselves have against a calibration: too few, too alike, not even."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.special import stdtr

from bayescal.calibration.judging.laplace import degrees
from bayescal.comparison.adequacy.outcome import p_words
from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.misfit import BECAUSE, GRAVE
from bayescal.comparison.lenses.places import named_places
from bayescal.comparison.lenses.prediction import observed_sample, response
from bayescal.comparison.lenses.results import Evidenced
from bayescal.inference.correlation import PART
from bayescal.rounding import counted, significant

USUAL_SIGMA = (0.05, 0.3)  # px: of corner detectors
FEW_VIEWS = 5
LOUD = 2.0  # times the usual residuals: a view that stands out
CELLS = (4, 3)
NOTICEABLE = 0.05  # px
PARALLEL = 8.0  # degrees that normals of planes should differ by at least
WIDER = 1.5  # times: where the spread over views is to be quoted
OPEN = 0.1  # of the prior's deviation: a posterior so wide along some combination is said
WORDS = {  # coordinates of the intrinsics
    "f": "focal length", "fx": "focal length", "fy": "aspect ratio",
    "cx": "principal point", "cy": "principal point",
}  # fmt: skip
HALVES = (  # as `left_out.halves` makes them, and what a difference between them says
    ("every second view and the others", "views err together in a way that the error model lacks"),
    ("the first half of the views and the rest", "the camera may have moved or changed"),
)
COVERED = 0.85  # of the radius of the image's corners


def few_views(basis: Evidenced) -> Finding | None:
    """Too few views to tell noise from lens."""
    n = len(basis.views)
    if n >= FEW_VIEWS:
        return None
    return limits(
        "few-views",
        f"{counted(n, 'view')} only: what differs from view to view is hardly known; take more",
    )


def parallel(basis: Evidenced) -> Finding | None:
    """Planes that are all parallel can't tell the focal length from the distance."""
    if not basis.setting.data.planar or len(basis.views) < 2:
        return None
    normals = basis.problem.poses.rotation[:, :, 2]
    mean = normals.mean(axis=0)
    angle = math.degrees(math.acos(min(1.0, float((normals @ mean / np.linalg.norm(mean)).min()))))
    if angle > PARALLEL:
        return None
    return limits(
        "parallel",
        f"the target is nearly parallel in all views (within {angle:.1f} degrees): focal length "
        "and distance can't be told apart; tilt it",
    )


def undetermined(basis: Evidenced) -> Finding | None:
    """Find what the views leave nearly as open as the prior, by the posterior's eigenvectors."""
    model = basis.problem.model
    _, sd = model.plain_prior
    inner = basis.drawn.covariance[: len(sd), : len(sd)] / np.outer(sd, sd)
    values, vectors = np.linalg.eigh(inner)
    wide = math.sqrt(values[-1])
    if wide < OPEN:
        return None
    shares = np.abs(vectors[:, -1])
    names = [model.names[j] for j in np.argsort(-shares) if shares[j] >= PART]
    said = list(dict.fromkeys(WORDS.get(name, name) for name in names))
    what = f"what the {said[0]} is" if len(said) == 1 else f"{' and '.join(said)} apart"
    return limits(
        "undetermined",
        f"these views hardly tell {what}: there the posterior is {100 * wide:.0f}% as wide as the "
        "prior; add views from other sides and distances",
    )


def loud_views(basis: Evidenced) -> Finding | None:
    """Name views whose residuals stand out."""
    data = basis.setting.data
    squares = (basis.problem.noise**2).sum(axis=(1, 2))
    per_view = np.sqrt(squares / data.counts)
    loud = np.flatnonzero(per_view > LOUD * np.median(per_view))
    if not len(loud):
        return None
    names = ", ".join(
        f"{basis.views.names[v]} ({per_view[v] / np.median(per_view):.1f} times)" for v in loud[:4]
    )
    return limits(
        "loud-views",
        f"residuals of some views are far larger than usual: {names}; check these photographs",
    )


def by_place(basis: Evidenced) -> Finding | None:
    """Residuals that depend on where in the image they are, the same in most views.

    A t test of the views' means in each cell and direction, p-values times their number.
    """
    data, residuals = basis.setting.data, basis.problem.noise
    edges = [np.linspace(0, s, n + 1)[1:-1] for s, n in zip(data.size, CELLS, strict=True)]
    cell = [np.digitize(data.pixels[..., axis], edges[axis]) for axis in (0, 1)]
    means, p_values = [], []
    for column in range(CELLS[0]):
        for row in range(CELLS[1]):
            here = (cell[0] == column) & (cell[1] == row) & data.seen
            counts = here.sum(axis=1)
            views = counts >= 3
            if views.sum() < FEW_VIEWS:
                continue
            own = (residuals * here[..., None]).sum(axis=1)[views] / counts[views][:, None]
            mean, error = own.mean(axis=0), own.std(axis=0, ddof=1) / math.sqrt(len(own))
            means.append(np.abs(mean))
            # Student's t: scipy.stats has it too, whose import takes a third of the command's.
            with np.errstate(divide="ignore", invalid="ignore"):
                p_values.append(2 * stdtr(len(own) - 1, -np.abs(mean) / error))
    if not means:
        return None
    size, p = np.array(means), np.array(p_values)
    far = (p * p.size < GRAVE) & (size > NOTICEABLE)
    if not far.any():
        return None
    return overturns(
        "misfit: surface",
        f"residuals depend on the place in the image ({int(far.any(axis=1).sum())} of "
        f"{CELLS[0] * CELLS[1]} cells, up to {significant(float(size[far].max()))} px): the lens "
        "has a shape that the model lacks",
        BECAUSE["surface"],
    )


def drift(basis: Evidenced) -> Finding | None:
    """Two halves of the views that disagree, at some place of the image.

    Chi-squared of what lies between their predictions there by both posteriors, p-values times
    their number.
    """
    view, data, splits = basis.best.view, basis.setting.data, basis.drawn.halves
    names, pixels = zip(*named_places(data.size), strict=True)
    maps = response(view, np.array(pixels), observed_sample(data), None)
    number, called = len(splits) * len(names), []
    for split, why in zip(splits, HALVES, strict=False):
        for name, by_lens in zip(names, maps, strict=True):
            if np.isfinite(by_lens).all():
                apart = by_lens @ split.apart
                noise = np.linalg.pinv(by_lens @ split.covariance @ by_lens.T, hermitian=True)
                chance = number * math.exp(-float(apart @ noise @ apart) / 2)
                if chance < GRAVE:
                    called.append((math.hypot(*apart), chance, name, why))
    if not called:
        return None
    why = min(called, key=lambda one: one[1])[3]
    size, chance, name, (which, cause) = max(one for one in called if one[3] == why)
    return limits(
        "drift",
        f"{which} disagree by {significant(size)} px at the {name}, more than noise allows ("
        f"{p_words(chance)} after Bonferroni over {number}): {cause}",
    )


def wider(basis: Evidenced) -> Finding | None:
    """Find a spread over views clearly larger than the posterior's."""
    ratios = [
        p.jackknife / p.infinity for p in basis.places if p.jackknife is not None and p.infinity
    ]
    if not ratios or np.median(ratios) < WIDER:
        return None
    return limits(
        "spread",
        f"the spread over views is {np.median(ratios):.1f} times the posterior's deviation: quote "
        "the spread (column jackknife)",
    )


def cover(basis: Evidenced) -> Finding | None:
    """Corners of the image that no point comes near."""
    data = basis.setting.data
    pixels = data.pixels[data.seen]
    middle = (np.array(data.size) - 1) / 2
    reach = float(np.hypot(*(pixels - middle).T).max()) / (math.hypot(*data.size) / 2)
    try:
        area = float(ConvexHull(pixels).volume) / (data.size[0] * data.size[1])
    except QhullError:
        area = 0.0
    if reach >= COVERED and area >= 0.6:
        return None
    return limits(
        "cover",
        f"points cover {100 * area:.0f}% of the image and reach {100 * reach:.0f}% of the way to "
        "its corners: what is said of the corners is extrapolated",
    )


def sigma_unusual(basis: Evidenced) -> Finding | None:
    """Noise far from what corner detectors have."""
    if basis.setting.level.sigma is not None:
        return None
    problem = basis.problem
    sigma = math.sqrt(problem.reduced.sum_of_squares / degrees(problem.data))
    low, high = USUAL_SIGMA
    total = basis.best.rms / math.sqrt(2)
    if total > high:
        return limits(
            "noise",
            f"residuals of {significant(total)} px are above a corner detector's usual {low:g} to "
            f"{high:g} px: look for blur, wrong corners, or a lens that is not among these",
        )
    if sigma < low / 3:
        return limits(
            "noise", f"a noise of {sigma:.2g} px is below what detectors reach: check the points"
        )
    return None
