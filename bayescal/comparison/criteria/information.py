"""Information criteria from the full maximised likelihood."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from bayescal.arrays import LOG_2PI
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.noise.level import NoiseLevel


@dataclass(frozen=True)
class Criterion:
    """An information criterion.

    Attributes
    ----------
    key : str
        In documents and data frames.
    name : str
        In tables; they show how far it lies above the smallest.
    meaning : str
        For a table's column.
    value : callable
        Of -2 lnL, K, n and whether sigma is inferred; None where it is undefined.
    across : bool
        Whether it compares models of r and c together, of one family and of several.
    """

    key: str
    name: str
    meaning: str
    value: Callable[[float, int, int, bool], float | None]
    across: bool = True


def _aic(minus_2_log_l: float, k: int, _n: int, _inferred: bool) -> float:
    return minus_2_log_l + 2 * k


def _aicc(minus_2_log_l: float, k: int, n: int, inferred: bool) -> float | None:
    spare = n - k - 1
    if not inferred or spare <= 0:
        return None
    return minus_2_log_l + 2 * k + 2 * k * (k + 1) / spare


def _bic(minus_2_log_l: float, k: int, n: int, _inferred: bool) -> float:
    return minus_2_log_l + k * math.log(n)


# A criterion is one entry here: tables, documents and data frames show what is listed.
CRITERIA = (
    # Akaike 1974.
    Criterion("aic", "AIC", "Akaike's criterion, -2 ln L + 2K", _aic),
    # Hurvich & Tsai 1989; where sigma is inferred and n > K + 1, and not across families.
    Criterion("aicc", "AICc", "AIC corrected for few points", _aicc, across=False),
    # Schwarz 1978.
    Criterion("bic", "BIC", "Schwarz's criterion, -2 ln L + K ln n, n points", _bic),
)
ACROSS = tuple(c for c in CRITERIA if c.across)


@dataclass(frozen=True)
class Criteria:
    """Likelihood criteria of one model; nothing but K for an exact fit.

    Attributes
    ----------
    n_parameters : int
        K: coefficients, plus one for each sigma that is inferred.
    log_likelihood : float or None
        Maximised, with every constant.
    values : mapping of str to float or None
        Of each of `CRITERIA`, by its key.
    """

    n_parameters: int
    log_likelihood: float | None = None
    values: Mapping[str, float | None] = field(default_factory=dict)

    @classmethod
    def of(
        cls, k: int, log_likelihood: float, n: int, *, inferred: bool, across: bool = False
    ) -> Criteria:
        """Evaluate every criterion of K parameters and `n` points, or those that go `across`."""
        found = {
            c.key: c.value(-2 * log_likelihood, k, n, inferred) if c.across or not across else None
            for c in CRITERIA
        }
        return cls(k, log_likelihood, found)

    @property
    def aic(self) -> float | None:
        """Akaike's criterion."""
        return self.values.get("aic")

    @property
    def aicc(self) -> float | None:
        """AIC corrected for few points."""
        return self.values.get("aicc")

    @property
    def bic(self) -> float | None:
        """Schwarz's criterion."""
        return self.values.get("bic")


def criteria(fit: LeastSquaresFit, noise: NoiseLevel, n: int, log_sd: float = 0.0) -> Criteria:
    """Information criteria of one order.

    Parameters
    ----------
    n : int
        Number of points.
    log_sd : float, optional
        Sum of ln sd over points whose deviations are known.
    """
    return criteria_from(fit.rss, len(fit.coefficients), noise, n, exact=fit.exact, log_sd=log_sd)


def criteria_from(
    rss: float,
    n_coefficients: int,
    noise: NoiseLevel,
    n: int,
    *,
    exact: bool = False,
    log_sd: float = 0.0,
) -> Criteria:
    """Information criteria of any model with Gaussian noise, from its sum of squares.

    Parameters
    ----------
    rss : float
        Residual sum of squares, px^2 (with known deviations: dimensionless).
    n : int
        Number of points.
    exact : bool, optional
        Whether the residuals are rounding, so that there is no likelihood.
    log_sd : float, optional
        Sum of ln sd over points whose deviations are known.
    """
    sigma = noise.plug_in
    inferred = sigma is None
    k = n_coefficients + inferred
    if exact:
        return Criteria(k)
    if sigma is None:
        log_likelihood = -n / 2 * (LOG_2PI + math.log(rss / n) + 1) - log_sd
    else:
        chi2 = rss / sigma**2
        log_likelihood = -0.5 * (chi2 + n * LOG_2PI) - n * math.log(sigma) - log_sd
    return Criteria.of(k, log_likelihood, n, inferred=inferred)


def robust_criteria(names: Sequence[str]) -> Criteria:
    """K alone: the likelihood may have no maximum. Everything inferred counts but tau."""
    return Criteria(sum(not name.startswith("tau") for name in names))
