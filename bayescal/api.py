"""The public functions: points or arrays in, a comparison out."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.analysis import Progress, analyse_arrays, analyse_points
from bayescal.arrays import Array, ArrayLike
from bayescal.comparison.results import Comparison, OrderResult
from bayescal.errors import InputError
from bayescal.inference.least_squares import LeastSquaresFit, factorise, solve
from bayescal.models.linear import generic_axis
from bayescal.models.pinhole import Radial
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import axis_names
from bayescal.settings import DEFAULT_ESS, DEFAULT_ORDERS, Settings, checked_orders

if TYPE_CHECKING:  # a plain comparison does not pay for the families
    from bayescal.comparison.families import FamilyComparison


def compare(
    points: Correspondences,
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    axis: str = "both",
    sigma: float | str | None = None,
    prior: str | None = None,
    tau: float | None = None,
    noise: str = "gaussian",
    nu: float | None = None,
    bad_offset: bool = False,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
    defend: bool = False,
    hint: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Compare polynomial orders of the separable family, axis by axis.

    Parameters
    ----------
    points : Correspondences
        From `load`, `thesis` or ``Correspondences.from_arrays``.
    orders : iterable of int, optional
        Polynomial degrees, 1 to 5 by default.
    axis : str, optional
        ``"r"``, ``"c"`` or ``"both"``.
    sigma : float or str, optional
        Noise level: a known number of px, or ``"inferred"``. By default the
        points' own deviations where they have them, else inferred.
    prior : str, optional
        ``"field"``, ``"flat"`` or ``"stated"``; by default the setup's own where
        it states one, else field.
    tau : float, optional
        Fixes the strength of the non-linearity of the field prior, as a fraction
        of the image; by default it is inferred.
    noise : str, optional
        ``"gaussian"``, ``"student-t"`` (heavy tails) or ``"outlier-mixture"`` (good and
        bad points); the latter two are sampled without a closed form, which takes longer.
    nu : float, optional
        Fixes the degrees of freedom of Student-t noise; by default they are inferred.
    bad_offset : bool, optional
        Infer an offset of the mixture's bad points; by default it is zero.
    seed : int, optional
        Of all randomness.
    ess : int, optional
        Effective samples wanted of every parameter.
    defend : bool, optional
        Also answer a referee: leave-one-out, sensitivity to the prior, stability under
        removal and resampling of points, orders beyond the range (some seconds more).
    hint : bool, optional
        Look whether another family or a free camera position is decisively better.
    progress : callable, optional
        Called with axis and order before each model is sampled.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        Where the points can't determine an order, or a setting is not usable.
    """
    wanted = checked_orders(orders)
    settings = Settings(sigma, prior, tau, seed, ess, defend, noise, nu, bad_offset)
    by_axis = dict.fromkeys(axis_names(axis), wanted)
    result = analyse_points(points, by_axis, settings, progress)
    if not hint:
        return result
    from bayescal.family_analysis import family_hint

    return dataclasses.replace(result, hint=family_hint(points, result, settings))


def compare_families(
    points: Correspondences,
    families: Sequence[str] = ("separable", "bivariate", "pinhole"),
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    position: Sequence[str] | None = None,
    radial: Radial = "even",
    radial_orders: Sequence[int] = (0, 1, 2, 3),
    sigma: float | str | None = None,
    prior: str | None = None,
    tau: float | None = None,
    noise: str = "gaussian",
    nu: float | None = None,
    bad_offset: bool = False,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
    progress: Progress | None = None,
) -> FamilyComparison:
    """Compare families of models of r and c together, their orders and the camera position.

    Parameters
    ----------
    points : Correspondences
    families : sequence of str, optional
        Of ``"separable"``, ``"bivariate"``, ``"pinhole"``.
    orders : iterable of int, optional
        Polynomial degrees; every pair of them in the separable family.
    position : sequence of str, optional
        ``"stated"``, ``"free"`` or both; by default stated, and free for a pinhole.
    radial : str, optional
        ``"even"`` or ``"all"`` powers of the radius in the pinhole's distortion.
    radial_orders : sequence of int, optional
        Numbers of radial coefficients.
    sigma, prior, tau, noise, nu, bad_offset, seed, ess, progress
        As in `compare`; noise other than Gaussian for the pinhole alone.

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        Where the points can't determine a model, or a setting is not usable.
    """
    from bayescal.family_analysis import compare_joint

    settings = Settings(sigma, prior, tau, seed, ess, False, noise, nu, bad_offset)
    numbers = tuple(sorted(set(radial_orders)))
    wanted = checked_orders(orders)
    return compare_joint(points, families, wanted, position, radial, settings, numbers, progress)


def fit_family(
    points: Correspondences,
    family: str,
    orders: tuple[int, ...],
    *,
    position: str | None = None,
    radial: Radial = "even",
    sigma: float | str | None = None,
    prior: str | None = None,
    tau: float | None = None,
    noise: str = "gaussian",
    nu: float | None = None,
    bad_offset: bool = False,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
) -> FamilyComparison:
    """Fit one model of r and c together; what `compare_families` gives, with one model.

    Parameters
    ----------
    points : Correspondences
    family : str
    orders : tuple of int
        Of r and c in the separable family, else one.
    position : str, optional
        ``"stated"`` or ``"free"``; by default stated, and free for a pinhole.
    radial, sigma, prior, tau, noise, nu, bad_offset, seed, ess
        As in `compare_families`.

    Returns
    -------
    FamilyComparison

    Raises
    ------
    InputError
        As `compare_families`.
    """
    from bayescal.family_analysis import compare_joint

    settings = Settings(sigma, prior, tau, seed, ess, False, noise, nu, bad_offset)
    radial_orders = checked_orders(orders, lowest=0) if family == "pinhole" else (0,)
    degrees = (1,) if family == "pinhole" else checked_orders(orders)
    pair = [(orders[0], orders[-1])] if family == "separable" else None
    where = None if position is None else (position,)
    return compare_joint(
        points, (family,), degrees, where, radial, settings, radial_orders, None, pair
    )


def fit(
    points: Correspondences,
    order_r: int | None = None,
    order_c: int | None = None,
    *,
    sigma: float | str | None = None,
    prior: str | None = None,
    tau: float | None = None,
    noise: str = "gaussian",
    nu: float | None = None,
    bad_offset: bool = False,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
    progress: Progress | None = None,
) -> Comparison:
    """Fit one order per axis; what `compare` gives, with a single order each.

    Parameters
    ----------
    points : Correspondences
    order_r, order_c : int, optional
        Polynomial degrees; an axis without one is left out.
    sigma, prior, tau, noise, nu, bad_offset, seed, ess, progress
        As in `compare`.

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
    settings = Settings(sigma, prior, tau, seed, ess, False, noise, nu, bad_offset)
    return analyse_points(points, orders, settings, progress)


def compare_polynomials(
    x: ArrayLike,
    y: ArrayLike,
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    sigma: float | ArrayLike | None = None,
    prior: str = "field",
    tau: float | None = None,
    noise: str = "gaussian",
    nu: float | None = None,
    bad_offset: bool = False,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
) -> Comparison:
    """Compare polynomial orders of y as a function of x, without any camera.

    The span of y stands for the image size in the prior and in the bounds of
    sigma.

    Parameters
    ----------
    x, y : array_like
        ``(n_points,)``.
    orders : iterable of int, optional
        Polynomial degrees.
    sigma : float or array_like, optional
        Known standard deviation of y, one or ``(n_points,)``; inferred by default.
    prior : str, optional
        ``"field"`` or ``"flat"``.
    tau, noise, nu, bad_offset, seed, ess
        As in `compare`; the widths that bad points may have scale with the span of y.

    Returns
    -------
    Comparison
        With the single axis ``"y"``.

    Raises
    ------
    InputError
        As `compare`.
    """
    values, known = _per_point_or_known(sigma)
    data = generic_axis(np.asarray(x), np.asarray(y), values)
    settings = Settings(known, prior, tau, seed, ess, False, noise, nu, bad_offset)
    return analyse_arrays(data, checked_orders(orders), settings)


def fit_polynomial(
    x: ArrayLike,
    y: ArrayLike,
    order: int,
    *,
    sigma: float | ArrayLike | None = None,
    prior: str = "field",
    tau: float | None = None,
    noise: str = "gaussian",
    nu: float | None = None,
    bad_offset: bool = False,
    seed: int = 0,
    ess: int = DEFAULT_ESS,
) -> OrderResult:
    """Fit one polynomial order of y as a function of x.

    Parameters
    ----------
    x, y : array_like
        ``(n_points,)``.
    order : int
        Polynomial degree.
    sigma, prior, tau, noise, nu, bad_offset, seed, ess
        As in `compare_polynomials`.

    Returns
    -------
    OrderResult
        ``.fit`` holds the least-squares coefficients and standard errors,
        ``.posterior`` the draws and their summaries.

    Raises
    ------
    InputError
        As `compare`.
    """
    result = compare_polynomials(
        x,
        y,
        [order],
        sigma=sigma,
        prior=prior,
        tau=tau,
        noise=noise,
        nu=nu,
        bad_offset=bad_offset,
        seed=seed,
        ess=ess,
    )
    return result.axes["y"].orders[0]


def least_squares(
    x: ArrayLike, y: ArrayLike, order: int, *, sd: float | ArrayLike | None = None
) -> LeastSquaresFit:
    """Least-squares polynomial of y as a function of x, nothing sampled.

    Parameters
    ----------
    x, y : array_like
        ``(n_points,)``.
    order : int
        Polynomial degree.
    sd : float or array_like, optional
        Known standard deviation of y, one or ``(n_points,)``.

    Returns
    -------
    LeastSquaresFit
        Monomial coefficients, lowest power first, with standard errors.

    Raises
    ------
    InputError
        Where the points can't determine the order.
    """
    values = np.asarray(sd, dtype=float) if sd is not None else None
    data = generic_axis(np.asarray(x), np.asarray(y), values)
    (order,) = checked_orders([order])
    with threadpool_limits(1):
        return solve(factorise(data, order), order, None if values is None else 1.0)


def _per_point_or_known(
    sigma: float | ArrayLike | None,
) -> tuple[Array | None, float | None]:
    """Tell deviations per point from one known sigma."""
    if sigma is None:
        return None, None
    values = np.asarray(sigma, dtype=float)
    return (values, None) if values.ndim else (None, float(values))
