r"""What errors of the regressor take of a curve that is fitted at its measured places.

With x_i = xi_i + d_i measured for xi_i, d_i of deviation s_i, the pixel f(xi_i) is f(x_i) -
f'(x_i) d_i + f''(x_i) d_i^2 / 2 to second order. The measured design D(x_i) has D'(xi_i) d_i of the
same error in it, so that weighted least squares is off on average by

    -A^-1 sum_i w_i s_i^2 (D'_i f'_i + D_i f''_i / 2),   A = sum_i w_i D_i D_i'

(attenuation; of a straight line -slope s^2 / var(x): Fuller 1987, *Measurement Error Models*, 1.1).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from bayescal.arrays import Array
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import legendre_design

PLACES = 101  # over the domain, where the curve is looked at


class Attenuation(NamedTuple):
    """How far a fitted curve is off on average, where that is most in its standard errors.

    Attributes
    ----------
    place : float
        The regressor.
    shift : float
        Of the curve there, px.
    standard_errors : float
        Its size in standard errors of the curve there.
    """

    place: float
    shift: float
    standard_errors: float


def attenuation(data: AxisData, sd: Array, amplitudes: Array) -> Attenuation:
    """Find where errors of the regressor take most of a curve, in its standard errors.

    Parameters
    ----------
    data, sd, amplitudes
        As of `bent_by_errors`.
    """
    off, root = bent_by_errors(data, sd, amplitudes)
    at = np.linspace(-1, 1, PLACES)
    looked = legendre_design(at, len(amplitudes) - 1)
    shift = looked @ off
    own = np.linalg.norm(np.linalg.solve(root.T, looked.T), axis=0)
    worst = int(np.argmax(np.abs(shift) / own))
    place = data.domain.middle + data.domain.half_range * float(at[worst])
    return Attenuation(place, float(shift[worst]), float(abs(shift[worst]) / own[worst]))


def bent_by_errors(data: AxisData, sd: Array, amplitudes: Array) -> tuple[Array, Array]:
    """Find how far least squares is off on average, to second order in the regressor's errors.

    Parameters
    ----------
    data : AxisData
        With the regressor's deviations `x_sd`.
    sd : Array
        Deviations of the residuals, errors of the regressor among them, ``(n_points,)``, px.
    amplitudes : Array
        Legendre amplitudes of the curve, ``(p,)``, px.

    Returns
    -------
    tuple of Array
        What is added to the amplitudes, ``(p,)``, px, and the triangular root of A, ``(p, p)``.
    """
    assert data.x_sd is not None, "only where the regressor has deviations"
    domain, order = data.domain, len(amplitudes) - 1
    s, error = domain.scale(data.x), data.x_sd / domain.half_range
    design = legendre_design(s, order)
    eye = np.eye(order + 1)
    steep = np.column_stack([legendre.legval(s, legendre.legder(e)) for e in eye])
    bent = legendre.legval(s, legendre.legder(amplitudes, 2))
    weight = 1 / sd**2
    pulled = steep * (steep @ amplitudes)[:, None] + design * bent[:, None] / 2
    pull = (weight * error**2) @ pulled
    root = np.linalg.qr(design * np.sqrt(weight)[:, None], mode="r")
    return -np.linalg.solve(root, np.linalg.solve(root.T, pull)), root
