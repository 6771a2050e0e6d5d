"""Polynomials of y as a function of x, without any camera."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Unpack

import numpy as np
from threadpoolctl import threadpool_limits

from bayescal.api.options import PolynomialOptions, spelled_out
from bayescal.arrays import Array, ArrayLike
from bayescal.comparison.analysis import analyse_arrays
from bayescal.comparison.results import Comparison, OrderResult
from bayescal.comparison.settings import DEFAULT_ORDERS, Settings, checked_orders
from bayescal.linear.least_squares import LeastSquaresFit, factorise, solve
from bayescal.polynomials.axis_data import generic_axis


@spelled_out(PolynomialOptions)
def compare_polynomials(
    x: ArrayLike,
    y: ArrayLike,
    orders: Iterable[int] = DEFAULT_ORDERS,
    *,
    sigma: float | ArrayLike | None = None,
    **options: Unpack[PolynomialOptions],
) -> Comparison:
    """Compare polynomial orders of y as a function of x, without any camera.

    The span of y stands for the image size in the prior, in the bounds of sigma and in the
    widths that bad points may have.

    Parameters
    ----------
    x, y : array_like
        ``(n_points,)``.
    orders : iterable of int, optional
        Polynomial degrees.
    sigma : float or array_like, optional
        Known standard deviation of y, one or ``(n_points,)``; inferred by default.
    **options : PolynomialOptions
        Of noise, prior and sampling: see `bayescal.comparison.settings.Settings`.

    Returns
    -------
    Comparison
        With the single axis ``"y"``.

    Raises
    ------
    InputError
        Where the points can't determine an order, or a setting is not usable.
    """
    values, known = _per_point_or_known(sigma)
    data = generic_axis(np.asarray(x), np.asarray(y), values)
    settings = Settings(**options, sigma=known, defend=False)
    return analyse_arrays(data, checked_orders(orders), settings)


@spelled_out(PolynomialOptions)
def fit_polynomial(
    x: ArrayLike,
    y: ArrayLike,
    order: int,
    *,
    sigma: float | ArrayLike | None = None,
    **options: Unpack[PolynomialOptions],
) -> OrderResult:
    """Fit one polynomial order of y as a function of x.

    Parameters
    ----------
    x, y : array_like
        ``(n_points,)``.
    order : int
        Polynomial degree.
    sigma : float or array_like, optional
        Known standard deviation of y, one or ``(n_points,)``; inferred by default.
    **options : PolynomialOptions
        Of noise, prior and sampling: see `bayescal.comparison.settings.Settings`.

    Returns
    -------
    OrderResult
        ``.fit`` holds the least-squares coefficients and standard errors,
        ``.posterior`` the draws and their summaries.

    Raises
    ------
    InputError
        As `compare_polynomials`.
    """
    return compare_polynomials(x, y, [order], sigma=sigma, **options).axes["y"].orders[0]


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
