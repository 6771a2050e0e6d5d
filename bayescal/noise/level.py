"""What is known of the pixel noise's level: sigma known, inferred, or a scale."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.pixel import FLOOR
from bayescal.prior.probit import log_prior, log_value, probit_of

# Bounds of an inferred sigma, pixels or what stands for them (ln sigma uniform between them).
SIGMA_BOUNDS = (FLOOR, 1000.0)

# Bounds of an inferred factor on known deviations.
SCALE_BOUNDS = (0.01, 100.0)
# Standard deviation of rounding to whole pixels, px: that of a uniform of width 1.
WHOLE_PIXEL = 1 / math.sqrt(12)


def sigma_bounds(pixel: float) -> tuple[float, float]:
    """Bounds of an inferred sigma where `pixel` stands for a pixel."""
    return SIGMA_BOUNDS[0] * pixel, SIGMA_BOUNDS[1] * pixel


@dataclass(frozen=True)
class NoiseLevel:
    """Scale sigma of the noise: known, or inferred between bounds.

    Attributes
    ----------
    source : str
        ``"known"``, ``"replicates"``, ``"inferred"``, or ``"scale"``: a factor on the
        points' own deviations, inferred.
    value : float or None
        Sigma of every point, px; with known deviations per point it is the factor 1
        on them; None where it is inferred.
    bounds : tuple of float or None
        Bounds of an inferred sigma, px (of a scale: a factor); its logarithm is
        uniform between them.
    dof : int or None
        Degrees of freedom of a sigma from replicates.
    mass : float
        Share of the prior of an inferred sigma that lies between the bounds: below 1 where
        the rounding of the readings rules the rest out.
    pure : float or None
        Sigma of the replicates' spread alone, px.
    """

    source: str
    value: float | None
    bounds: tuple[float, float] | None
    dof: int | None = None
    mass: float = 1.0
    pure: float | None = None

    @classmethod
    def known(cls, sigma: float) -> NoiseLevel:
        """Sigma known, px.

        Raises
        ------
        InputError
            Where sigma is not positive and finite.
        """
        if not 1e-100 < sigma < 1e100:
            raise InputError(f"sigma must be a positive number of px, not {sigma:g}")
        return cls("known", sigma, None)

    @classmethod
    def inferred(cls, bounds: tuple[float, float] = SIGMA_BOUNDS) -> NoiseLevel:
        """Sigma inferred, ln sigma uniform between bounds, px."""
        return cls("inferred", None, bounds)

    @classmethod
    def inferred_in(cls, pixel: float) -> NoiseLevel:
        """Sigma inferred, its bounds in units of what stands for a pixel."""
        return cls.inferred(sigma_bounds(pixel))

    @classmethod
    def replicates(cls, sigma: float, dof: int, pixel: float = 1.0) -> NoiseLevel:
        """Sigma from the spread of true replicates, px, with that spread's own uncertainty.

        A uniform ln sigma that has seen the replicates' spread is a scaled inverse chi-squared
        of their degrees of freedom (Gelman et al. 2013, 2.6): the prior under which the places'
        means are judged. As the likelihood of all points holds the spread too, the two together
        are an inferred sigma's uniform prior times that likelihood; to take the inverse
        chi-squared and all points would count the spread twice.
        """
        return cls("replicates", None, sigma_bounds(pixel), dof, pure=sigma)

    @property
    def plug_in(self) -> float | None:
        """Sigma that likelihood criteria are at, px: known, or of the replicates alone."""
        return self.value if self.value is not None else self.pure

    @classmethod
    def scale(cls) -> NoiseLevel:
        """Infer a factor on the points' own deviations."""
        return cls("scale", None, SCALE_BOUNDS)

    @property
    def parameter(self) -> str:
        """Name of the inferred parameter."""
        return "scale" if self.source == "scale" else "sigma"

    @property
    def log_bounds(self) -> tuple[float, float]:
        """Bounds of ln sigma of an inferred sigma."""
        assert self.bounds is not None, "sigma is known"
        return math.log(self.bounds[0]), math.log(self.bounds[1])

    def bounded(self, rss: float, n: int) -> float:
        """Sigma: known, or most probable within its bounds, of a weighted sum of `n` squares."""
        if self.bounds is None:
            assert self.value is not None, "it is known or has bounds"
            return self.value
        return min(max(math.sqrt(rss / n), self.bounds[0]), self.bounds[1])

    def likely(self, rss: float, n: int) -> float:
        """Sigma: known, or the most likely one whatever its bounds, of the same."""
        return math.sqrt(max(rss, 1e-300) / n) if self.value is None else self.value

    def on_readings(self, t: Array, sd: Array | None = None) -> NoiseLevel:
        """Rule out an inferred sigma below the rounding of whole-pixel readings.

        Where noise is well below a pixel, readings at equal regressors are equal numbers, and
        a density grows without limit about them: with a free bad fraction 20 of the thesis's
        57 readings of c were "good" at sigma = 0.011 px, the rest bad, with an evidence 19 nat
        above that of all other fits together. The density above the bound is as before, so
        that evidences stay comparable with those of other noise.

        Parameters
        ----------
        t : Array
            Readings, ``(n_points,)``, px.
        sd : Array, optional
            The points' own deviations, ``(n_points,)``, px; their median counts.
        """
        if self.bounds is None or not (t == np.round(t)).all():
            return self
        lower, upper = self.bounds
        raised = WHOLE_PIXEL / (1.0 if sd is None else float(np.median(sd)))
        if not lower < raised < upper:
            return self
        kept = math.log(upper / raised) / math.log(upper / lower)
        return replace(self, bounds=(raised, upper), mass=self.mass * kept)

    def log_prior(self) -> float:
        """Log density of ln sigma inside the bounds; 0 where sigma is known."""
        if self.bounds is None:
            return 0.0
        lower, upper = self.log_bounds
        return math.log(self.mass / (upper - lower))

    # Samplers see an inferred sigma as a probit (`bayescal.prior.probit`).

    def log_sigma(self, probit: Array) -> Array:
        """Log of an inferred sigma at probits, of their shape."""
        return log_value(probit, self.log_bounds)

    def probit(self, sigma: float, least: float = 0.001) -> float:
        """Probit of a sigma, px, kept off the bounds: from the share `least` of their distance."""
        lower, _ = self.log_bounds
        return probit_of(math.log(max(sigma, math.exp(lower))), self.log_bounds, least)

    def log_probit_prior(self, probit: Array) -> Array:
        """Log prior density per unit of the probit, of its shape."""
        return np.asarray(math.log(self.mass) + log_prior(probit))
