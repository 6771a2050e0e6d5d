"""r and c as polynomials of x/z and y/z: the mapping alone, without a posterior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from bayescal.arrays import Array
from bayescal.polynomials.basis import Domain, legendre_design
from bayescal.polynomials.plane import plane_columns, powers
from bayescal.prediction.calibrated.hull import within
from bayescal.prediction.calibrated.members import BoolArray

EDGE = 1e-9  # of the domain: rounding at its ends


@dataclass(frozen=True, eq=False)
class PolynomialMap:
    """r and c as polynomials of the regressors, scaled to [-1, 1].

    Parameters theta begin with the Legendre amplitudes of r, then those of c (px).

    Attributes
    ----------
    orders : tuple of int
        Of r and of c.
    domains : tuple of Domain
        Of x/z and of y/z.
    bivariate : bool
        Whether each is a polynomial of both.
    hull : Array
        Corners of the calibration points' hull in the scaled regressors, ``(m, 2)``.
    """

    orders: tuple[int, int]
    domains: tuple[Domain, Domain]
    bivariate: bool
    hull: Array

    def columns(self, axis: int) -> int:
        """Count the amplitudes of r (0) or c (1)."""
        k = self.orders[axis]
        return plane_columns(k) if self.bivariate else k + 1

    def amplitudes(self, theta: Array) -> tuple[Array, Array]:
        """Amplitudes of r and of c, ``(m, p)`` each."""
        first, second = self.columns(0), self.columns(1)
        return theta[:, :first], theta[:, first : first + second]

    def scaled(self, ratios: Array) -> Array:
        """Scale x/z and y/z, ``(..., 2)``."""
        s = [domain.scale(ratios[..., i]) for i, domain in enumerate(self.domains)]
        return np.stack(s, axis=-1)

    def ratios(self, scaled: Array) -> Array:
        """x/z and y/z of scaled regressors, ``(..., 2)``."""
        out = [d.middle + d.half_range * scaled[..., i] for i, d in enumerate(self.domains)]
        return np.stack(out, axis=-1)

    def design(self, scaled: Array, axis: int) -> Array:
        """Design of r (0) or c (1) at scaled regressors ``(..., 2)``, ``(..., p)``."""
        k = self.orders[axis]
        if not self.bivariate:
            return legendre_design(scaled[..., axis], k)
        # The first power is of the axis's own regressor.
        first, second = np.array(powers(k)).T
        own, other = (legendre_design(scaled[..., i], k) for i in (axis, 1 - axis))
        return np.asarray(own[..., first] * other[..., second])

    def at_scaled(self, theta: Array, scaled: Array) -> Array:
        """Pixels at scaled regressors ``(m, n, 2)`` or ``(1, n, 2)``, ``(m, n, 2)``."""
        out = []
        for axis, b in enumerate(self.amplitudes(theta)):
            design = self.design(scaled, axis)
            if len(design) == 1:
                out.append(b @ design[0].T)
            else:
                out.append(np.einsum("mnp,mp->mn", design, b))
        return np.stack(out, axis=-1)

    def with_slopes(self, theta: Array, scaled: Array) -> tuple[Array, Array]:
        """Pixels ``(m, n, 2)`` and their derivatives by scaled regressors, ``(m, n, 2, 2)``."""
        value, slope = np.empty(scaled.shape), np.zeros((*scaled.shape, 2))
        for axis, b in enumerate(self.amplitudes(theta)):
            k = self.orders[axis]
            own = legendre_design(scaled[..., axis], k)
            turn = _derivative(k)
            if not self.bivariate:
                value[..., axis] = np.einsum("mnp,mp->mn", own, b)
                slope[..., axis, axis] = np.einsum("mnp,mp->mn", own @ turn, b)
                continue
            other = legendre_design(scaled[..., 1 - axis], k)
            i, j = np.array(powers(k)).T
            value[..., axis] = np.einsum("mnp,mp->mn", own[..., i] * other[..., j], b)
            by_own, by_other = (
                (own @ turn)[..., i] * other[..., j],
                own[..., i] * (other @ turn)[..., j],
            )
            slope[..., axis, axis] = np.einsum("mnp,mp->mn", by_own, b)
            slope[..., axis, 1 - axis] = np.einsum("mnp,mp->mn", by_other, b)
        return value, slope

    def in_domain(self, scaled: Array) -> BoolArray:
        """Whether scaled regressors ``(..., 2)`` lie in the calibrated domain, ``(...)``."""
        if self.bivariate:
            return within(self.hull, scaled)
        low, high = self.box
        return np.asarray(((scaled >= low) & (scaled <= high)).all(axis=-1))

    @property
    def box(self) -> tuple[Array, Array]:
        """Ends of the calibrated domain of both scaled regressors, ``(2,)`` each."""
        low, high = self.hull.min(axis=0), self.hull.max(axis=0)
        slack = EDGE * (high - low)
        return low - slack, high + slack


def _derivative(order: int) -> Array:
    """Matrix that takes P_0 ... P_k to their derivatives, from the right, ``(k + 1, k + 1)``."""
    out = np.zeros((order + 1, order + 1))
    for k in range(1, order + 1):
        slopes = legendre.legder(np.eye(order + 1)[k])
        out[: len(slopes), k] = slopes
    return out
