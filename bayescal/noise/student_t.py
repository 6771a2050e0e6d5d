r"""Student-t noise: tails as heavy as the data ask for.

A residual is sigma times a Student-t variable of nu degrees of freedom. nu is inferred,
nu ~ Gamma(2, 0.1) (mean 20; Juarez & Steel 2010, J. Bus. Econ. Stat. 28, 52), or fixed.
sigma is the scale of the t, not its standard deviation, which is sigma sqrt(nu / (nu - 2))
and infinite for nu <= 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from scipy.special import betaln

from bayescal.arrays import Array, IntArray
from bayescal.errors import InputError
from bayescal.noise.model import WORTH, NoiseModel, scales, sum_log1p

# Prior of an inferred nu: Gamma(shape, rate).
SHAPE, RATE = 2.0, 0.1
# What a fixed nu may be; above it no double tells the noise from Gaussian.
FIXED_NU = (0.1, 1e10)
# Limits of |ln nu| within which it is evaluated: its prior is below exp(-100) beyond.
LARGEST_LOG = 50.0


@dataclass(frozen=True)
class StudentT:
    """Residuals are sigma times a Student-t variable.

    eta is ln nu, or nothing where nu is fixed.

    Attributes
    ----------
    nu : float or None
        Degrees of freedom where they are fixed; None: inferred.
    """

    name: ClassVar[str] = "student-t"
    words: ClassVar[str] = "Student-t"
    level: ClassVar[str] = "its scale sigma"
    options: ClassVar[tuple[str, ...]] = ("nu",)
    columns: ClassVar[Mapping[str, tuple[str, str]]] = {
        "nu": ("nu", "degrees of freedom of Student-t noise"),
    }
    tells_bad: ClassVar[bool] = False
    conjugate: ClassVar[bool] = False

    nu: float | None = None

    def __post_init__(self) -> None:
        if self.nu is not None and not FIXED_NU[0] <= self.nu <= FIXED_NU[1]:
            raise InputError(f"nu must be from {FIXED_NU[0]:g} to {FIXED_NU[1]:g}, not {self.nu:g}")

    @classmethod
    def of(cls, pixel: float, **options: Any) -> Self:  # noqa: ARG003 - nu has no unit
        """Make it, nu fixed or inferred."""
        return cls(**options)

    @property
    def chosen(self) -> dict[str, Any]:
        """A fixed nu."""
        return {"nu": self.nu}

    def described(self, unit: str) -> str:
        """Name it and nu."""
        inferred = f"~ Gamma(shape {SHAPE:g}, rate {RATE:g})"
        return f"Student-t, nu {inferred if self.nu is None else f'= {self.nu:g}'}"

    @property
    def priors(self) -> dict[str, Any]:
        """Nu's prior, or its value."""
        inferred = {"kind": "gamma", "shape": SHAPE, "rate": RATE}
        return {"nu": inferred if self.nu is None else {"kind": "fixed", "value": self.nu}}

    @property
    def parameters(self) -> tuple[str, ...]:
        """``("nu",)`` where it is inferred."""
        return ("nu",) if self.nu is None else ()

    @property
    def dimension(self) -> int:
        """1 where nu is inferred, else 0."""
        return int(self.nu is None)

    def _nu(self, eta: Array) -> Array:
        """Degrees of freedom of each draw, ``(n_draws, 1)``."""
        if self.nu is not None:
            return np.full((len(eta), 1), self.nu)
        return np.exp(np.clip(eta, -LARGEST_LOG, LARGEST_LOG))

    def taken(self, part: slice | IntArray) -> NoiseModel:
        """Give itself: it knows no points."""
        return self

    def log_density(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Log density of residuals, ``(n_draws, n_points)``; see NoiseModel."""
        nu, log_scale = self._nu(eta), scales(log_sigma, sd)
        z = residual * np.exp(-log_scale)
        return np.asarray(_constant(nu) - log_scale - (nu + 1) / 2 * np.log1p(z * z / nu))

    def total(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Sum of `log_density` over the points, ``(n_draws,)``."""
        if residual.shape[1] < WORTH:
            return np.asarray(self.log_density(residual, log_sigma, eta, sd).sum(axis=1))
        nu, log_scale = self._nu(eta), scales(log_sigma, sd)
        n = residual.shape[1]
        z = residual * (np.exp(-log_scale) / np.sqrt(nu))
        z *= z
        fixed = n * _constant(nu)[:, 0] - log_scale.sum(axis=1) * (n / log_scale.shape[1])
        return np.asarray(fixed - (nu[:, 0] + 1) / 2 * sum_log1p(z))

    def log_prior(self, eta: Array) -> Array:
        """Log density of Gamma(2, 0.1) per unit of ln nu, ``(n_draws,)``."""
        if self.nu is not None:
            return np.zeros(len(eta))
        log_nu = eta[:, 0]
        # Gamma(2) = 1 and d nu = nu d ln nu.
        return np.asarray(
            SHAPE * (log_nu + np.log(RATE)) - RATE * np.exp(np.minimum(log_nu, LARGEST_LOG))
        )

    def report(self, eta: Array) -> Array:
        """Degrees of freedom nu, ``(n_draws, 1)``; nothing where they are fixed."""
        return self._nu(eta) if self.nu is None else np.empty((len(eta), 0))

    def starts(self) -> Array:
        """Light tails and heavy ones, ``(2, 1)``; one start where nu is fixed."""
        return np.log([[20.0], [2.0]]) if self.nu is None else np.empty((1, 0))

    def draw(self, rng: np.random.Generator, log_sigma: Array, eta: Array, sd: Array) -> Array:
        """Simulate residuals, ``(n_draws, n_points)``, px."""
        size = (len(eta), len(sd))
        drawn: Array = np.exp(scales(log_sigma, sd)) * rng.standard_t(self._nu(eta), size)
        return drawn

    def bad_probability(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array | None:
        """Give None: every point is of the same kind."""
        return None

    def weight(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """(nu + 1) / (nu + z^2), ``(n_draws, n_points)`` (Lange, Little & Taylor 1989)."""
        nu = self._nu(eta)
        z = residual * np.exp(-scales(log_sigma, sd))
        return np.asarray((nu + 1) / (nu + z * z))


def _constant(nu: Array) -> Array:
    """Log density at 0 of a scale of 1.

    The beta function keeps its digits where two gamma functions of a large nu don't.
    """
    return np.asarray(-betaln(0.5, nu / 2) - np.log(nu) / 2)


NOISE = StudentT
