"""Information criteria from the full maximised likelihood."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from bayescal.arrays import LOG_2PI
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.noise.level import NoiseLevel


@dataclass(frozen=True)
class Criteria:
    """Likelihood criteria of one order; all None for an exact fit.

    Attributes
    ----------
    n_parameters : int
        K: coefficients, plus one where sigma is inferred.
    log_likelihood : float or None
        Maximised, with every constant.
    aic : float or None
        -2 lnL + 2 K (Akaike 1974).
    aicc : float or None
        AIC + 2 K (K + 1) / (n - K - 1) (Hurvich & Tsai 1989); only where sigma is
        inferred and n > K + 1.
    bic : float or None
        -2 lnL + K ln n (Schwarz 1978).
    """

    n_parameters: int
    log_likelihood: float | None = None
    aic: float | None = None
    aicc: float | None = None
    bic: float | None = None


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
    aic = -2 * log_likelihood + 2 * k
    spare = n - k - 1
    aicc = aic + 2 * k * (k + 1) / spare if inferred and spare > 0 else None
    return Criteria(k, log_likelihood, aic, aicc, -2 * log_likelihood + k * math.log(n))


def robust_criteria(names: Sequence[str]) -> Criteria:
    """K alone: the likelihood may have no maximum. Everything inferred counts but tau."""
    return Criteria(sum(not name.startswith("tau") for name in names))
