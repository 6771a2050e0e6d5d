"""Polynomials of a camera's points, axis by axis: the separable family."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, Unpack

from bayescal.api.given import Given, GivenSetup, reduced, resumed
from bayescal.api.options import Options, spelled_out
from bayescal.comparison.analysis import Progress, analyse_points
from bayescal.comparison.results import Comparison
from bayescal.comparison.settings import DEFAULT_ORDERS, Settings, checked_orders
from bayescal.comparison.store import Store
from bayescal.errors import InputError
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import axis_names


@spelled_out(Options)
def compare(
    points: Given,
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    axis: str = "both",
    defend: bool = False,
    hint: bool = True,
    setup: GivenSetup = None,
    resume: str | Path | None = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> Comparison:
    """Compare polynomial orders of the separable family, axis by axis.

    Parameters
    ----------
    points : Correspondences, str, Path, DataFrame or array_like
        From `load`, `thesis` or ``Correspondences.from_arrays``, or anything `load` takes.
    orders : iterable of int, optional
        Polynomial degrees, 1 to 5 by default.
    axis : str, optional
        ``"r"``, ``"c"`` or ``"both"``.
    defend : bool, optional
        Also answer a referee: leave-one-out, sensitivity to the prior, stability under
        removal and resampling of points, orders beyond the range (some ten seconds more).
    hint : bool, optional
        Look whether another family or a free camera position is decisively better.
    setup : Setup or str or Path, optional
        What is known of the camera, where the points don't know it.
    resume : str or Path, optional
        Folder that keeps what was sampled without a closed form as soon as it is: called again
        with the same arguments after an interruption, it goes on from there.
    progress : callable, optional
        Called with axis and order before each model is sampled; before other work with its
        name and 0.
    **options : Options
        Of noise, prior and sampling: see `bayescal.comparison.settings.Settings`.

    Returns
    -------
    Comparison
        One comparison per axis, as ``result["r"]``; ``result["r"].verdict`` is the answer,
        ``result["r"][4]`` an order. ``to_dataframe()``, ``summary()``, ``covariance()`` and
        ``to_arviz()`` convert it.

    Raises
    ------
    InputError
        Where the points can't determine an order, or a setting is not usable.

    Notes
    -----
    Strength of evidence: Kass & Raftery 1995. Evidence and posterior have a closed form under
    Gaussian noise (Bishop 2006, 3.3, 3.5); draws are emcee's (Foreman-Mackey et al. 2013).
    docs/method.md has every equation.
    """
    return compared(
        points,
        Settings(**options, defend=defend),
        partial(resumed, resume),
        orders,
        axis=axis,
        hint=hint,
        setup=setup,
        progress=progress,
    )


def compared(
    points: Given,
    settings: Settings,
    store_of: Callable[[Correspondences, Settings, Any], Store | None],
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    axis: str = "both",
    hint: bool = True,
    setup: GivenSetup = None,
    progress: Progress | None = None,
) -> Comparison:
    """Compare as `compare` does, posteriors from a store made for points, settings and orders."""
    by_axis = dict.fromkeys(axis_names(axis), checked_orders(orders))
    points, whole, again = reduced(points, setup, by_axis, settings)
    store = store_of(points, settings, by_axis)
    result = analyse_points(points, by_axis, settings, progress, store, whole, again)
    return _hinted(points, result, settings, progress) if hint else result


@spelled_out(Options)
def fit(
    points: Given,
    order_r: int | None = None,
    order_c: int | None = None,
    *,
    setup: GivenSetup = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> Comparison:
    """Fit one order per axis; what `compare` gives, with a single order each.

    Parameters
    ----------
    points : Correspondences, str, Path, DataFrame or array_like
        From `load`, `thesis` or ``Correspondences.from_arrays``, or anything `load` takes.
    order_r, order_c : int, optional
        Polynomial degrees; an axis without one is left out.
    setup, progress : optional
        As in `compare`.
    **options : Options
        Of noise, prior and sampling: see `bayescal.comparison.settings.Settings`.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        As `compare`.
    """
    orders = {a: checked_orders([k]) for a, k in (("r", order_r), ("c", order_c)) if k is not None}
    if not orders:
        raise InputError("give the order of r, of c or of both")
    settings = Settings(**options, defend=False)
    points, whole, _ = reduced(points, setup, orders, settings)
    result = analyse_points(points, orders, settings, progress, whole=whole)
    return _hinted(points, result, settings, progress)


def _hinted(
    points: Correspondences, result: Comparison, settings: Settings, progress: Progress | None
) -> Comparison:
    """Say whether another family or a free position is decisively better."""
    if progress is not None:
        progress("looking at other families", 0)
    from bayescal.comparison.families.hint import family_hint

    return result.with_hint(family_hint(points, result, settings))
