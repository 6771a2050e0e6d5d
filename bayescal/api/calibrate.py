"""Lens models compared over many views of a target."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bayescal.api.given import resumed
from bayescal.comparison.lenses.analysis import compare_lenses
from bayescal.comparison.lenses.request import GAUSSIAN, LensRequest, checked_noise
from bayescal.comparison.lenses.results import LensComparison
from bayescal.comparison.settings import Settings
from bayescal.errors import InputError
from bayescal.points.views.notes import alike, scrambled
from bayescal.points.views.reader import load_views
from bayescal.points.views.views import Views
from bayescal.rounding import grouped

PER_VIEW = "per-view"
# Points that are taken: they are held with their slopes, some 3 kB each.
MOST = 1_000_000
# Numbers of covariances of noise that neighbours share: half a GB.
MOST_SHARED = 60_000_000


def calibrate(
    views: Any,
    *,
    lenses: Sequence[str] | None = None,
    sigma: float | str | None = None,
    noise: str = GAUSSIAN,
    independent: bool = False,
    square: bool = False,
    centred: bool = False,
    seed: int = 0,
    ess: int = 400,
    resume: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> LensComparison:
    """Compare lens models by their evidence, the poses of the views integrated out.

    Parameters
    ----------
    views : Views, str, Path or DataFrame
        At least two photographs of one target by one camera, or what `bayescal.load_views`
        reads.
    lenses : sequence of str, optional
        Such as ``"radial 2"``, ``"radial 2 + p"`` (with tangential terms), ``"fisheye 3"`` or
        ``"opencv5"``; by default they are found, plain ones first, while the evidence rises.
    sigma : float or str, optional
        Known standard deviation of r and c, px; inferred by default; ``"per-view"``: each view
        has its own, how they compare settled from residuals, their common factor inferred. With
        the views' own deviations it is a factor on them.
    noise : str, optional
        ``"gaussian"``; ``"outlier-mixture"``: each point may also be bad, with a probability that
        is inferred, and then anywhere in the image.
    independent : bool, optional
        Take noise as independent and the target as exact, which no real target is: the error
        models (correlated noise, points of the target that are off, a target that bows) are
        then left out.
    square, centred : bool, optional
        Hold fx = fy; hold the principal point in the middle of the image.
    seed : int, optional
        Seed of the random numbers.
    ess : int, optional
        Effective samples wanted of every parameter.
    resume : str or Path, optional
        Folder that keeps every lens as soon as it is judged, and what is drawn: called again with
        the same arguments after an interruption, it goes on from there.
    progress : callable, optional
        Called with what is being done.

    Returns
    -------
    LensComparison
        Lenses, the most probable first; ``verdict`` is the answer, the recommended lens's posterior
        is in ``summary()``, ``covariance()`` and ``to_arviz()``.

    Raises
    ------
    InputError
        Where an option can't be used, or no lens can be fitted.

    Notes
    -----
    Poses and the target's offsets are eliminated by Schur complements, and the evidence comes from
    importance sampling; docs/method.md, *Many views*, has every step.
    """
    checked_noise(noise)
    known = None if sigma in ("inferred", PER_VIEW) else sigma
    if isinstance(known, str) or not (known is None or 0 < known < math.inf):
        raise InputError(
            f"sigma must be inferred, {PER_VIEW} or a positive number of px, not {known}"
        )
    if not isinstance(views, Views):
        views = load_views(views)
    if len(views) < 2:
        raise InputError(
            f"{views.source}: one view can't tell lens from pose; take at least two, better ten"
        )
    if views.n_points > MOST:
        raise InputError(
            f"{views.source}: {grouped(views.n_points)} points are more than the "
            f"{grouped(MOST)} that fit into memory; take fewer views (--only, --without)"
        )
    if not independent:
        _check_shared(views)
    if alike(views):
        raise InputError(
            f"{views.source}: all views are alike, which tell no more of a lens than one does; add "
            "views from other sides and distances"
        )
    if odd := scrambled(views):
        raise InputError(f"{views.source}: {odd} name them anew, or leave it out: --without VIEW")
    names = None if lenses is None else tuple(lenses)
    request = LensRequest(
        names, independent, square, centred, per_view=sigma == PER_VIEW, noise=noise
    )
    settings = Settings(sigma=known, seed=seed, ess=ess)
    store = resumed(resume, views, settings, request)
    return compare_lenses(views, request, settings, progress or (lambda _: None), store)


def _check_shared(views: Views) -> None:
    """Refuse views for which noise that neighbours share takes more memory than there may be."""
    counts = np.bincount(views.view)
    largest, count = int(counts.max()), len(counts)
    if (counts == largest).all():
        shown = views.corner[np.argsort(views.view, kind="stable")].reshape(count, -1)
        count = 1 if (shown == shown[0]).all() else count
    if max(count * largest**2, len(views.target) ** 2) > MOST_SHARED:
        raise InputError(
            f"{views.source}: {grouped(len(counts))} views of up to {grouped(largest)} points: the "
            "noise that neighbours share does not fit into memory; take fewer points, or "
            "independent noise (--independent)"
        )
