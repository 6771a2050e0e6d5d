r"""A proposal for a pinhole's posterior: one t for each strength of the distortion.

With tau integrated out, the displacements' density is a spike on a plateau, which no few
components learnt from draws follow (2 % of them effective at order 2 of the thesis data).
Given tau it is nearly normal: the proposal is a mixture over a ladder of tau of the Laplace
approximations, weighted by their masses, with a broad defensive component.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array
from bayescal.density.pinholes.gaussian import GaussianPinhole
from bayescal.density.pinholes.laplace import laplace
from bayescal.inference.estimate import EvidenceEstimate, from_weights
from bayescal.inference.optimum import Mode
from bayescal.inference.proposals.laplace_mixture import mixture_about
from bayescal.inference.weighting import drawn

# Steps of the ladder in ln tau.
STEP = 0.65


def weighted_evidence(
    model: GaussianPinhole, rng: np.random.Generator, draws: int
) -> EvidenceEstimate:
    """Evidence from weighted draws of the ladder alone, without a chain."""
    return from_weights(drawn(model, mixture_about(*ladder(model)), rng, draws)[1])


def ladder(model: GaussianPinhole) -> tuple[tuple[Mode, ...], Array]:
    """Laplace approximation at each tau of a ladder, and the log of its share of the evidence.

    Returns
    -------
    modes : tuple of Mode
        In sampled coordinates; one where tau is no parameter.
    log_mass : Array
        Their logs sum to the Laplace approximation of the log evidence, ``(n_modes,)``.
    """
    prior, frame = model.prior, model.frame
    if model.infers_tau:
        low, high = prior.log_tau_bounds
        edges = np.linspace(low, high, math.ceil((high - low) / STEP) + 1)
        rungs = np.exp((edges[1:] + edges[:-1]) / 2).tolist()
    else:
        rungs = [prior.tau if prior.tau is not None else 1.0]
    modes, start = [], frame.mean
    for tau in rungs[::-1]:
        found = laplace(model.geometry, prior, model.data, start, tau)
        fixed = replace(model, prior=replace(prior, tau=tau))
        theta = frame.whitened(found.mean)
        root = solve_triangular(frame.root, found.root, lower=True)
        modes.append(Mode(theta, float(fixed.log_prob(theta[None])[0]), root))
        start = found.mean
    return tuple(modes), np.array([m.log_mass for m in modes]) - np.log(len(rungs))
