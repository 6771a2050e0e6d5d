"""What the general path needs of a likelihood model that has no closed form."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from bayescal.arrays import Array


class SampledModel(Protocol):
    """A likelihood model whose posterior and evidence come from sampling alone.

    Its sampled coordinates theta are unconstrained; parameters whose conditional is
    known in closed form (a sigma, a tau) may be integrated out of `log_prob` and drawn
    afterwards by `complete`.
    """

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        ...

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the reported parameters."""
        ...

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior per unit of theta, both normalised.

        Parameters
        ----------
        theta : Array
            ``(n_draws, dimension)``.

        Returns
        -------
        Array
            ``(n_draws,)``, nat; -inf outside the support, never NaN.
        """
        ...

    def starts(self) -> Array:
        """Places to search for modes from, ``(n_starts, dimension)``."""
        ...

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Draw what was integrated out, ``(n_draws, n_full)``, theta's columns first."""
        ...

    def report(self, full: Array) -> Array:
        """Give completed draws in reported units, ``(n_draws, n_names)``."""
        ...

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each unit of data given completed draws, ``(n_draws, n_units)``.

        A unit is what leave-one-out leaves out: a pixel value of one axis, or r and c
        of a point together in a joint model.
        """
        ...
