"""Whitened coordinates, in which a posterior is near-spherical."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array
from bayescal.inference.proposals.proposal import Proposal


@dataclass(frozen=True, eq=False)
class Whitening:
    """The affine map theta = centre + factor @ u.

    Attributes
    ----------
    centre : Array
        ``(dimension,)``.
    factor : Array
        Lower triangular, ``(dimension, dimension)``.
    """

    centre: Array
    factor: Array

    def theta(self, u: Array) -> Array:
        """Parameters at whitened coordinates, ``(n, dimension)``."""
        return self.centre + u @ self.factor.T

    def u(self, theta: Array) -> Array:
        """Whitened coordinates of parameters, ``(n, dimension)``."""
        return solve_triangular(self.factor, (theta - self.centre).T, lower=True).T


@dataclass(frozen=True, eq=False)
class WhitenedProposal:
    """A proposal seen in whitened coordinates (densities per unit of theta)."""

    proposal: Proposal
    whitening: Whitening

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw whitened coordinates, ``(size, dimension)``."""
        return self.whitening.u(self.proposal.draw(rng, size))

    def log_density(self, u: Array) -> Array:
        """Log density at whitened coordinates, ``(n,)``, per unit of theta."""
        return self.proposal.log_density(self.whitening.theta(u))
