"""Families of joint models of r and c."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Unpack

from bayescal.api.given import Given, GivenSetup, many_of, points_of, resumed
from bayescal.api.options import Options, spelled_out
from bayescal.cameras.pinhole import Radial
from bayescal.comparison.analysis import Progress
from bayescal.comparison.families.analysis import check_request, compare_joint
from bayescal.comparison.families.reduced import can_reduce_families, reduce_families
from bayescal.comparison.families.request import FamilyRequest
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.settings import DEFAULT_ORDERS, Settings, checked_orders
from bayescal.points.chunks.many import ManyPoints
from bayescal.points.correspondences import Correspondences
from bayescal.polynomials.whole import Whole

RADIAL_ORDERS = (0, 1, 2, 3)
# Points of a model with a pose or position of its own: some twenty minutes a model.
MOVED = 500_000


@spelled_out(Options)
def compare_families(
    points: Given,
    families: Sequence[str] = ("separable", "bivariate", "pinhole"),
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    position: Sequence[str] | None = None,
    radial: Radial = "even",
    radial_orders: Iterable[int] = RADIAL_ORDERS,
    defend: bool = False,
    setup: GivenSetup = None,
    resume: str | Path | None = None,
    progress: Progress | None = None,
    **options: Unpack[Options],
) -> FamilyComparison:
    """Compare families of joint models of r and c, their orders and the camera position.

    Parameters
    ----------
    points : Correspondences, str, Path, DataFrame or array_like
        From `load`, `thesis` or ``Correspondences.from_arrays``, or anything `load` takes.
    families : sequence of str, optional
        Of ``"separable"``, ``"bivariate"``, ``"pinhole"``.
    orders : iterable of int, optional
        Polynomial degrees; every pair of them in the separable family.
    position : sequence of str, optional
        ``"stated"``, ``"free"`` or both; by default stated, and free for a pinhole.
    radial : str, optional
        ``"even"`` or ``"all"`` powers of the radius in the pinhole's distortion.
    radial_orders : iterable of int, optional
        Numbers of radial coefficients.
    defend : bool, optional
        Also say which points and groups the choice rests on.
    setup : Setup or str or Path, optional
        What is known of the camera, where the points don't know it.
    resume : str or Path, optional
        Folder that keeps what was sampled without a closed form as soon as it is: called again
        with the same arguments after an interruption, it goes on from there.
    progress : callable, optional
        Called with each model's name and 0 before it is judged, and before what follows.
    **options : Options
        Of noise, prior and sampling: see
        `bayescal.comparison.settings.Settings`.

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        Where the points can't determine a model, or a setting is not usable.
    """
    settings = Settings(**options, defend=defend)
    request = family_request(families, orders, position, radial, radial_orders)
    points, whole = _reduced(points, setup, request, settings)
    store = resumed(resume, points, settings, request)
    return compare_joint(points, request, settings, progress, store, whole)


def family_request(
    families: Sequence[str],
    orders: Iterable[int],
    position: Sequence[str] | None = None,
    radial: Radial = "even",
    radial_orders: Iterable[int] = RADIAL_ORDERS,
) -> FamilyRequest:
    """Say which models are wanted; parameters and errors as of `compare_families`."""
    return FamilyRequest(
        tuple(dict.fromkeys(families)),
        checked_orders(orders),
        None if position is None else tuple(position),
        radial,
        checked_orders(radial_orders, lowest=0),
    )


@spelled_out(Options)
def fit_family(
    points: Given,
    family: str,
    orders: tuple[int, ...],
    *,
    position: str | None = None,
    radial: Radial = "even",
    setup: GivenSetup = None,
    **options: Unpack[Options],
) -> FamilyComparison:
    """Fit one joint model of r and c; what `compare_families` gives, with one model.

    Parameters
    ----------
    points : Correspondences, str, Path, DataFrame or array_like
        From `load`, `thesis` or ``Correspondences.from_arrays``, or anything `load` takes.
    family : str
    orders : tuple of int
        Of r and c in the separable family, else one.
    position : str, optional
        ``"stated"`` or ``"free"``; by default stated, and free for a pinhole.
    radial, setup : optional
        As in `compare_families`.
    **options : Options
        Of noise, prior and sampling: see
        `bayescal.comparison.settings.Settings`.

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        As `compare_families`.
    """
    settings = Settings(**options, defend=False)
    request = FamilyRequest.of_one(family, orders, position, radial)
    points, whole = _reduced(points, setup, request, settings)
    return compare_joint(points, request, settings, whole=whole)


def _reduced(
    given: Given | ManyPoints, setup: GivenSetup, request: FamilyRequest, settings: Settings
) -> tuple[Correspondences, dict[str, Whole] | None]:
    """Make correspondences for families, or of those with a closed form a sample and a reduction.

    Raises
    ------
    InputError
        As `points_of`.
    """
    check_request(request, settings)
    many = many_of(given, setup)
    if many is None:
        return points_of(given, setup), None
    if not can_reduce_families(many, request, settings):
        return (many.at_once(MOVED) if request.moves else many.at_once()), None
    return reduce_families(many, request, settings)
