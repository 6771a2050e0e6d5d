"""Truths of robust noise drawn from the prior, and their places among the draws.

The truths are drawn from the priors as docs/method.md states them, by scipy and apart from the
program, so that a prior the program gets wrong shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from scipy import stats

from bayescal.arrays import Array
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.sampled_posterior import sample_model
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.noise.outlier_mixture import OutlierMixture
from bayescal.noise.student_t import StudentT
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import PriorRule
from scripts.validation.ranks import DRAWS

SIZE = 1000.0  # px
X = np.linspace(-0.4, 0.7, 20)
NOISES: dict[str, NoiseModel] = {
    "Student-t, nu inferred": StudentT(),
    "Student-t, nu = 4": StudentT(4.0),
    "mixture": OutlierMixture(),
    "mixture with an offset": OutlierMixture(infers_offset=True),
}


@dataclass(frozen=True)
class Design:
    """What is simulated.

    Attributes
    ----------
    order : int
    sigma : float or None
        Known, px; None: from its prior and inferred.
    ess : int
        Asked of the sampler.
    """

    order: int = 2
    sigma: float | None = None
    ess: int = 1000


def simulated(
    noise: NoiseModel, design: Design, rng: np.random.Generator
) -> tuple[Array, AxisData]:
    """Draw the parameters, in the order they are reported in, and pixels made with them."""
    sigma, tail = design.sigma, []
    if sigma is None:
        sigma = float(stats.loguniform(0.01, 1000).rvs(random_state=rng))
        tail.append(sigma)
    scale = np.full(design.order + 1, SIZE / 2)
    if design.order > 1:
        tau = float(stats.loguniform(0.01 / SIZE, 0.5).rvs(random_state=rng))
        scale[2:] = tau * SIZE
        tail.append(tau)
    b = rng.normal(0, scale)
    b[0] += SIZE / 2
    own, residuals = _residuals(noise, sigma, rng)
    series = Legendre(b, domain=[X[0], X[-1]])
    labels = tuple(str(i + 1) for i in range(len(X)))
    data = AxisData(
        "r", "x/z", "alpha", X, series(X) + residuals, None, labels, SIZE, True, "simulated"
    )
    return np.concatenate([series.convert(kind=Polynomial).coef, tail, own]), data


def _residuals(
    noise: NoiseModel, sigma: float, rng: np.random.Generator
) -> tuple[list[float], Array]:
    """Parameters of the noise from their prior, and residuals, px."""
    if isinstance(noise, StudentT):
        nu = noise.nu or float(stats.gamma(2, scale=10).rvs(random_state=rng))
        drawn = sigma * stats.t(nu).rvs(len(X), random_state=rng)
        return [] if noise.nu else [nu], np.asarray(drawn)
    fraction = float(rng.uniform(0, 0.5))
    width = float(stats.loguniform(5, 1000).rvs(random_state=rng))
    offset = float(rng.normal(0, width)) if "bad_offset" in noise.parameters else 0.0
    bad = rng.random(len(X)) < fraction
    residuals = rng.normal(0, sigma, len(X)) + bad * rng.normal(offset, width, len(X))
    return [fraction, width, *([offset] if "bad_offset" in noise.parameters else [])], residuals


def posteriors(
    noise: NoiseModel, design: Design, simulations: int, rng: np.random.Generator
) -> tuple[tuple[str, ...], list[tuple[Array, Array]]]:
    """Sample the posterior of each simulation as the program does.

    Returns
    -------
    names : tuple of str
    simulations : list of tuple
        Truth, and ``(DRAWS, n_parameters)`` nearly independent draws.
    """
    level = NoiseLevel.inferred() if design.sigma is None else NoiseLevel.known(design.sigma)
    prior = PriorRule("field", SIZE, SIZE / 2).of_order(design.order)
    out = []
    for _ in range(simulations):
        truth, data = simulated(noise, design, rng)
        model = RobustLinearModel.of_order(data, design.order, level, prior, noise)
        chain = sample_model(model, rng, design.ess).chain
        apart = chain.draws.reshape(-1, chain.draws.shape[2])
        step = len(apart) // DRAWS
        out.append((truth, apart[::step][:DRAWS]))
    return model.names, out
