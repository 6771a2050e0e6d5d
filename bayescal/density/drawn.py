"""Draws of the two axes of a linear family, whatever they were sampled as."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from bayescal.arrays import Array
from bayescal.noise.model import NoiseModel


@dataclass(frozen=True, eq=False)
class DrawnAxis:
    """Draws of one axis, and the noise they are of.

    Attributes
    ----------
    amplitudes : Array
        Of the Legendre basis, ``(n_draws, n_coefficients)``, px.
    log_sigma : Array
        ``(n_draws,)``; of a scale where points have deviations of their own.
    eta : Array
        Coordinates of the noise model, ``(n_draws, noise.dimension)``.
    sd : Array or None
        The points' own deviations, ``(n_points,)``, px.
    """

    amplitudes: Array
    log_sigma: Array
    eta: Array
    noise: NoiseModel
    sd: Array | None


class LinearFamily(ABC):
    """Both axes of a linear family, sampled together."""

    @abstractmethod
    def drawn(self, full: Array) -> tuple[DrawnAxis, DrawnAxis]:
        """Take r and c out of completed draws."""

    def position(self, full: Array) -> Array | None:  # noqa: ARG002
        """Camera positions of draws, ``(n_draws, 3)``, world units; None where it is exact."""
        return None
