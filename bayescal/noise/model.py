"""What every noise model offers: the shape of the noise about a scale sigma."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, Self

import numpy as np

from bayescal.arrays import Array, IntArray


class NoiseModel(Protocol):
    """Shape of the noise about a scale sigma, with unconstrained coordinates eta of its own.

    The scale of point i is sigma times its own deviation, where it has one. A noise model
    without parameters has eta of shape ``(n_draws, 0)``.

    Attributes
    ----------
    name : str
        What the command line calls it: ``"gaussian"``, ``"student-t"``, ...
    words : str
        Its name as it stands in a sentence.
    level : str
        What sigma is, in words: ``"sigma"``, ``"its scale sigma"``.
    options : tuple of str
        Those of the user's options that it takes.
    columns : mapping of str to (str, str)
        Head of a table's column, and its meaning, of each of `parameters`.
    tells_bad : bool
        Whether it knows bad points.
    conjugate : bool
        Whether normal amplitudes integrate out in closed form; else the evidence is sampled.
    """

    name: ClassVar[str]
    words: ClassVar[str]
    level: ClassVar[str]
    options: ClassVar[tuple[str, ...]]
    columns: ClassVar[Mapping[str, tuple[str, str]]]
    tells_bad: ClassVar[bool]
    conjugate: ClassVar[bool]

    @classmethod
    def of(cls, pixel: float, **options: Any) -> Self:
        """Make it, with `options`; `pixel` stands for a pixel (`bayescal.points.pixel`)."""
        ...

    @property
    def chosen(self) -> dict[str, Any]:
        """Its options, as `of` takes them."""
        ...

    def described(self, unit: str) -> str:
        """Say what it is, with its priors; `unit` is of the residuals."""
        ...

    @property
    def priors(self) -> dict[str, Any]:
        """Bounds, priors and fixed values, as a result document names them."""
        ...

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of what is reported beside sigma."""
        ...

    @property
    def dimension(self) -> int:
        """Number of coordinates eta."""
        ...

    def taken(self, part: slice | IntArray) -> NoiseModel:
        """Give the noise of some of the points."""
        ...

    def log_density(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Log density of residuals, normalised.

        Parameters
        ----------
        residual : Array
            Measured less predicted, ``(n_draws, n_points)``, px.
        log_sigma : Array
            ``(n_draws,)``.
        eta : Array
            ``(n_draws, dimension)``.
        sd : Array, optional
            The points' own deviations, ``(n_points,)``, px; sigma is a factor on them.

        Returns
        -------
        Array
            ``(n_draws, n_points)``, nat per px.
        """
        ...

    def total(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Sum of `log_density` over the points, ``(n_draws,)``, nat."""
        ...

    def log_prior(self, eta: Array) -> Array:
        """Log prior density per unit of eta, normalised, ``(n_draws,)``."""
        ...

    def report(self, eta: Array) -> Array:
        """Parameters in their natural units, ``(n_draws, n_parameters)``."""
        ...

    def starts(self) -> Array:
        """Places to search for modes from, the heaviest tails last, ``(n_starts, dimension)``."""
        ...

    def draw(self, rng: np.random.Generator, log_sigma: Array, eta: Array, sd: Array) -> Array:
        """Simulate residuals, ``(n_draws, n_points)``, px; one column for each of `sd`."""
        ...

    def bad_probability(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array | None:
        """Probability that each point is bad, given the draw, ``(n_draws, n_points)``.

        None where the noise model does not tell bad points.
        """
        ...

    def weight(
        self, residual: Array, log_sigma: Array, eta: Array, sd: Array | None = None
    ) -> Array:
        """Share of a good point's precision that each point has, ``(n_draws, n_points)``.

        The expected precision of the normal that the residual came from, given the residual,
        times sigma^2: the weight of the point in a weighted least-squares step.
        """
        ...


def scales(log_sigma: Array, sd: Array | None) -> Array:
    """Log scale of each point, ``(n_draws, n_points)``, or ``(n_draws, 1)`` without `sd`."""
    column = log_sigma[:, None]
    return column if sd is None else column + np.log(sd)


# Numbers whose product is taken before its logarithm, and the fewest points that this is worth.
FACTORS, WORTH = 8, 1000


def sum_log1p(q: Array) -> Array:
    """Sum of ln(1 + q) over the points, q not negative; ``(n_draws,)`` of ``(n_draws, n_points)``.

    Of many points the logarithm of products is taken, a seventh of the time: each factor rounds
    by as much as 1 + q does, and a product that overflows is not believed.
    """
    if q.shape[1] < WORTH:
        return np.asarray(np.log1p(q).sum(axis=1))
    size = q.shape[1] // FACTORS
    parts = (q[:, : FACTORS * size] + 1).reshape(len(q), FACTORS, size)
    with np.errstate(over="ignore", invalid="ignore"):
        product = parts[:, 0] * parts[:, 1]
        for i in range(2, FACTORS):
            product *= parts[:, i]
        found = np.log(product).sum(axis=1) + np.log1p(q[:, FACTORS * size :]).sum(axis=1)
    if np.isfinite(found).all():
        return np.asarray(found)
    return np.asarray(np.log1p(q).sum(axis=1))
