"""Both axes of a linear family under a noise model without a closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from bayescal.arrays import Array
from bayescal.density.drawn import DrawnAxis, LinearFamily
from bayescal.density.robust_linear import RobustLinearModel
from bayescal.inference.chains.chain import Chain
from bayescal.inference.estimate import EvidenceEstimate
from bayescal.inference.optimum import Mode
from bayescal.inference.posterior import summarise
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.points.setup import AXES


@dataclass(frozen=True, eq=False)
class RobustPair(LinearFamily):
    """Models of r and of c at the stated position, which have nothing in common.

    theta: that of r, then that of c; completed draws: theta, then ln tau of each axis where it
    is inferred.
    """

    axes: tuple[RobustLinearModel, RobustLinearModel]

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        return sum(axis.dimension for axis in self.axes)

    @property
    def names(self) -> tuple[str, ...]:
        """Coefficients, sigma, tau and the noise's own parameters of r, then of c."""
        out: list[str] = []
        for axis, letter in zip(self.axes, AXES, strict=True):
            out += axis.coefficients
            out += [f"{name}_{letter}" for name in axis.names[axis.size :]]
        return tuple(out)

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior per unit of theta, ``(n_draws,)``, nat."""
        r, c = (a.log_prob(part) for a, part in zip(self.axes, self.apart(theta), strict=True))
        return np.asarray(r + c)

    def starts(self) -> Array:
        """Every start of r with every start of c."""
        r, c = (axis.starts() for axis in self.axes)
        return np.concatenate([np.repeat(r, len(c), axis=0), np.tile(c, (len(r), 1))], axis=1)

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Append ln tau of each axis, drawn given its amplitudes, where it is inferred."""
        return completed(self.axes, theta, self.apart(theta), rng)

    def report(self, full: Array) -> Array:
        """Give the reported parameters, ``(n_draws, n_names)``, px (tau: of the image)."""
        parts = zip(self.axes, self.apart(full), strict=True)
        return np.concatenate([axis.report(part) for axis, part in parts], axis=1)

    def drawn(self, full: Array) -> tuple[DrawnAxis, DrawnAxis]:
        """Take r and c out of completed draws."""
        r, c = (axis.drawn(part) for axis, part in zip(self.axes, self.apart(full), strict=True))
        return r, c

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each point, r and c jointly, ``(n_draws, n_points)``."""
        r, c = self.log_likelihoods(full)
        return np.asarray(r + c)

    def log_likelihoods(self, full: Array) -> tuple[Array, Array]:
        """Log density of each pixel value of r, and of c, each ``(n_draws, n_points)``.

        Each depends on its own axis's parameters alone, which are independent a posteriori:
        leaving out a point is leaving out its r and its c.
        """
        r, c = (a.log_likelihood(p) for a, p in zip(self.axes, self.apart(full), strict=True))
        return r, c

    def apart(self, full: Array) -> tuple[Array, Array]:
        """Coordinates of r and of c, of draws completed or not."""
        return taken_apart(self.axes, full, 0)


def taken_apart(
    axes: tuple[RobustLinearModel, RobustLinearModel], full: Array, first: int
) -> tuple[Array, Array]:
    """Coordinates of each axis, from column `first` on, with its ln tau where there is one."""
    middle = first + axes[0].dimension
    end = middle + axes[1].dimension
    r, c = full[:, first:middle], full[:, middle:end]
    if full.shape[1] == end:
        return r, c
    at = end
    out = []
    for axis, part in zip(axes, (r, c), strict=True):
        width = int(axis.prior.infers_tau)
        out.append(np.concatenate([part, full[:, at : at + width]], axis=1))
        at += width
    return out[0], out[1]


def completed(
    axes: tuple[RobustLinearModel, RobustLinearModel],
    theta: Array,
    parts: tuple[Array, Array],
    rng: np.random.Generator,
) -> Array:
    """Append to theta what is drawn given each axis's coordinates."""
    columns = [theta]
    for axis, part in zip(axes, parts, strict=True):
        columns.append(axis.complete(part, rng)[:, axis.dimension :])
    return np.concatenate(columns, axis=1)


def paired(r: SampledPosterior, c: SampledPosterior, model: RobustPair) -> SampledPosterior:
    """Pair draws of the two axes, which are independent a posteriori.

    The longer chain is thinned, and of each ensemble as many walkers kept as both have.
    Diagnostics are those of the axes' own chains.

    Parameters
    ----------
    model : RobustPair
        Of their models.
    """
    kept = _alike(r, c)
    full = [p.full[walkers][:, steps] for p, (walkers, steps) in zip((r, c), kept, strict=True)]
    theta = [f[..., : a.dimension] for f, a in zip(full, model.axes, strict=True)]
    taus = [f[..., a.dimension :] for f, a in zip(full, model.axes, strict=True)]
    everything = np.concatenate([*theta, *taus], axis=2)
    log_prob = sum(
        p.chain.log_prob[walkers][:, steps]
        for p, (walkers, steps) in zip((r, c), kept, strict=True)
    )
    draws = model.report(everything.reshape(-1, everything.shape[2]))
    chain = Chain(
        draws.reshape(*everything.shape[:2], -1),
        np.concatenate(theta, axis=2),
        np.asarray(log_prob),
        (*r.chain.diagnostics, *c.chain.diagnostics),
        min(r.chain.acceptance, c.chain.acceptance),
        max(r.chain.autocorrelation_time, c.chain.autocorrelation_time),
        r.chain.converged and c.chain.converged,
    )
    summaries, evidence = summarise(model.names, chain), _sum(r.estimate, c.estimate)
    return SampledPosterior(chain, summaries, model, everything, evidence, _modes(r, c))


def _alike(
    r: SampledPosterior, c: SampledPosterior
) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Chains and steps to keep of each axis: as many of both, spread over all."""
    shapes = [p.chain.draws.shape[:2] for p in (r, c)]
    walkers = min(n for n, _ in shapes)
    steps = min(n for _, n in shapes)
    out = []
    for chains, length in shapes:
        which = np.linspace(0, chains - 1, walkers).round().astype(np.intp)
        out.append((which, np.linspace(0, length - 1, steps).round().astype(np.intp)))
    return out


def _sum(r: EvidenceEstimate, c: EvidenceEstimate) -> EvidenceEstimate:
    """Evidence of the pair: the product, its errors in quadrature."""
    return replace(
        r,
        log_evidence=r.log_evidence + c.log_evidence,
        error=math.hypot(r.error, c.error),
        bridge=r.bridge + c.bridge,
        bridge_error=math.hypot(r.bridge_error, c.bridge_error),
        effective_fraction=min(r.effective_fraction, c.effective_fraction),
        pareto_k=max(r.pareto_k, c.pareto_k),
        draws=min(r.draws, c.draws),
        warnings=tuple(
            f"of {axis}: {line}"
            for axis, e in zip(AXES, (r, c), strict=True)
            for line in e.warnings
        ),
    )


def _modes(r: SampledPosterior, c: SampledPosterior) -> tuple[Mode, ...]:
    """Every mode of r with every mode of c, the highest first."""
    out = [
        Mode(np.concatenate([a.theta, b.theta]), a.value + b.value, block_diag(a.root, b.root))
        for a in r.modes
        for b in c.modes
    ]
    return tuple(sorted(out, key=lambda mode: -mode.value))
