"""A linear model under any noise model: what is sampled where no closed form exists."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from bayescal.arrays import LOG_2PI, Array, IntArray, in_parts
from bayescal.density.drawn import DrawnAxis
from bayescal.density.many_points import MANY, parabola, starts_of_sample
from bayescal.density.plain_fits import plain_fits
from bayescal.density.trimmed import trimmed_fits
from bayescal.errors import InputError
from bayescal.inference.optimum import Mode, climb
from bayescal.inference.sampled_posterior import EVIDENCE_DRAWS
from bayescal.noise.level import NoiseLevel
from bayescal.noise.model import NoiseModel
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.rows import ALL, BLOCK, Rows, blocks, rows_of
from bayescal.prior.amplitudes import CoefficientPrior
from bayescal.prior.strength import Strength

# Strengths tau at which a proposal is told how wide the density is.
RUNGS = 12
# Draws of the evidence of many points, whose posterior is nearly normal: 0.006 nat.
FEWER_DRAWS = 5000
# Densities held at once: in pieces that fit a cache the density takes half the time.
CHUNK = 100_000


@dataclass(frozen=True, eq=False)
class RobustLinearModel:
    """Pixels t = design @ b + noise, of any noise model; a `SampledModel`.

    theta: the amplitudes b, px; the probit of where ln sigma lies between its bounds,
    where sigma is inferred; then eta of the noise model. An inferred tau is integrated
    out, and drawn by `complete` as a last column, ln tau.

    Attributes
    ----------
    design : Rows
        ``(n_points, n_coefficients)``; of many points what makes parts of it.
    t : Array
        Measured pixels, ``(n_points,)``, px.
    sd : Array or None
        The points' own deviations, ``(n_points,)``, px.
    prior : CoefficientPrior
        Proper.
    to_reported : Array
        Reported coefficients = to_reported @ b, ``(n_coefficients, n_coefficients)``.
    coefficients : tuple of str
        Their names.
    """

    design: Rows
    t: Array
    sd: Array | None
    prior: CoefficientPrior
    level: NoiseLevel
    noise: NoiseModel
    to_reported: Array
    coefficients: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.prior.proper:
            raise InputError(
                f"{self.noise.name} noise needs a proper prior: under a flat one nothing says "
                "that the posterior exists; take the field prior or state one"
            )

    @classmethod
    def of_order(
        cls,
        data: AxisData,
        order: int,
        level: NoiseLevel,
        prior: CoefficientPrior,
        noise: NoiseModel,
    ) -> RobustLinearModel:
        """Set up one order of a linear family, reported in monomials.

        Raises
        ------
        InputError
            Where sigma is inferred from no more points than there are coefficients.
        """
        monomials, design = data.monomials(order), rows_of(data, order)
        if level.value is None and len(data) <= design.shape[1]:
            raise InputError(
                f"{data.source}: axis {data.axis}: {noise.name} noise with sigma inferred needs "
                f"more points than the {design.shape[1]} coefficients of order {order}; compare "
                "lower orders, state --sigma or add points"
            )
        return cls(
            design,
            data.t,
            data.sd,
            prior,
            level if data.generic else level.on_readings(data.t, data.sd),
            noise,
            monomials.lead(order),
            tuple(f"{data.symbol}_{powers}" for powers in monomials.suffixes),
        )

    @property
    def size(self) -> int:
        """Number of coefficients p."""
        return len(self.coefficients)

    @property
    def infers_sigma(self) -> bool:
        """Whether sigma (or the scale) is a parameter."""
        return self.level.value is None

    @property
    def dimension(self) -> int:
        """Number of sampled coordinates."""
        return self.size + self.infers_sigma + self.noise.dimension

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the reported parameters: coefficients, sigma, tau, then the noise's own."""
        inferred = (self.level.parameter,) * self.infers_sigma + ("tau",) * self.prior.infers_tau
        return self.coefficients + inferred + self.noise.parameters

    @cached_property
    def _strength(self) -> Strength:
        return Strength(self.prior.log_tau_bounds, int(self.prior.scaled.sum()))

    def log_sigma(self, theta: Array) -> Array:
        """Log of sigma (or of the scale) at each draw, ``(n_draws,)``."""
        if self.level.value is not None:
            return np.full(len(theta), math.log(self.level.value))
        return self.level.log_sigma(theta[:, self.size])

    def eta(self, theta: Array) -> Array:
        """Coordinates of the noise model at each draw, ``(n_draws, noise.dimension)``."""
        first = self.size + self.infers_sigma
        return theta[:, first : first + self.noise.dimension]

    def drawn(self, full: Array) -> DrawnAxis:
        """Take amplitudes and noise out of completed draws."""
        amplitudes = full[:, : self.size]
        return DrawnAxis(amplitudes, self.log_sigma(full), self.eta(full), self.noise, self.sd)

    def residuals(self, theta: Array) -> Array:
        """Measured less predicted pixels, ``(n_draws, n_points)``, px."""
        return np.asarray(self.t - theta[:, : self.size] @ self.design[ALL].T)

    def taken(self, part: slice | IntArray) -> RobustLinearModel:
        """Give the model of some of the points."""
        sd = None if self.sd is None else self.sd[part]
        noise = self.noise.taken(part)
        return replace(self, design=self.design[part], t=self.t[part], sd=sd, noise=noise)

    def blocks(self) -> Iterator[RobustLinearModel]:
        """Give the same model of all points block by block: likelihoods multiply."""
        if len(self.t) <= BLOCK:
            return iter([self])
        return (self.taken(part) for part in blocks(len(self.t)))

    def log_prob(self, theta: Array) -> Array:
        """Log of likelihood times prior per unit of theta, ``(n_draws,)``, nat."""
        density = self.fitted(theta) + self.log_prior(theta)
        return np.where(np.isnan(density), -np.inf, density)

    def fitted(self, theta: Array) -> Array:
        """Log likelihood, ``(n_draws,)``, nat: summed block by block, few draws at a time."""
        total = np.zeros(len(theta))
        for block in self.blocks():
            parts = in_parts(theta, len(block.t), CHUNK)
            total += np.concatenate([block._summed(part) for part in parts])
        return total

    def _summed(self, theta: Array) -> Array:
        log_sigma, eta = self.log_sigma(theta), self.eta(theta)
        return self.noise.total(self.residuals(theta), log_sigma, eta, self.sd)

    def log_prior(self, theta: Array) -> Array:
        """Log prior per unit of theta, normalised, ``(n_draws,)``."""
        density = self.noise.log_prior(self.eta(theta))
        if self.infers_sigma:
            density = density + self.level.log_probit_prior(theta[:, self.size])
        return np.asarray(density + self._log_amplitude_prior(theta[:, : self.size]))

    def _log_amplitude_prior(self, amplitudes: Array) -> Array:
        """Log prior of the amplitudes, an inferred tau integrated out, ``(n_draws,)``."""
        prior = self.prior
        log_tau = math.log(prior.tau) if prior.tau is not None else 0.0
        sd = prior.deviations(np.array([log_tau]))[0]
        z = (amplitudes - prior.mean) / sd
        terms = -(z * z + LOG_2PI) / 2 - np.log(sd)
        if not prior.infers_tau:
            return np.asarray(terms.sum(axis=1))
        q = (z[:, prior.scaled] ** 2).sum(axis=1)
        scaled = self._strength.log_density(q) - np.log(sd[prior.scaled]).sum()
        return np.asarray(terms[:, ~prior.scaled].sum(axis=1) + scaled)

    def starts(self) -> Array:
        """Least squares and an M-estimate with every start of the noise, then trimmed fits.

        The trimmed ones start from the noise model's heaviest tails: half of the points may
        agree on another curve than all do.
        """
        if len(self.t) > MANY:
            return starts_of_sample(self)
        own = np.ones(len(self.t)) if self.sd is None else self.sd
        x, y = self.design[ALL] / own[:, None], self.t / own
        noise = self.noise.starts()
        rows = [self.start(*fit, eta) for fit in plain_fits(x, y) for eta in noise]
        return np.array(rows + [self.start(*fit, noise[-1]) for fit in trimmed_fits(x, y)])

    def ladder(self, mode: Mode) -> tuple[Mode, ...]:
        """Modes at fixed tau, from its largest down, each climbed to from the one before.

        Where tau reaches far below the noise the density has a spike at amplitudes of nothing,
        as wide as each tau in turn, that no curvature at a mode tells.
        """
        if not self.prior.infers_tau:
            return ()
        lowest, highest = self.prior.log_tau_bounds
        many, rungs = len(self.t) > MANY, [mode]
        likelihood = parabola(self.fitted, mode) if many else self.fitted
        for log_tau in np.linspace(highest, lowest, RUNGS):
            fixed = replace(self, prior=replace(self.prior, tau=math.exp(log_tau)))

            def density(theta: Array, fixed: RobustLinearModel = fixed) -> Array:
                found = likelihood(theta) + fixed.log_prior(theta)
                return np.where(np.isnan(found), -np.inf, found)

            rungs.append(climb(density, rungs[-1].theta))
        return tuple(rungs[1:])

    @property
    def evidence_draws(self) -> int:
        """Draws that the evidence is taken from; fewer where each looks at many points."""
        return FEWER_DRAWS if len(self.t) > MANY else EVIDENCE_DRAWS

    def start(self, amplitudes: Array, scale: float, eta: Array) -> Array:
        """Give the coordinates of amplitudes and a sigma, px, with eta of the noise."""
        if not self.infers_sigma:
            return np.concatenate([amplitudes, eta])
        return np.array([*amplitudes, self.level.probit(scale, 0.01), *eta])

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Append ln tau, drawn given the amplitudes, where tau is inferred."""
        if not self.prior.infers_tau:
            return theta
        scaled = self.prior.scaled
        z = (theta[:, : self.size] - self.prior.mean)[:, scaled] / self.prior.sd[scaled]
        log_tau = self._strength.draw((z * z).sum(axis=1), rng)
        return np.column_stack([theta, log_tau])

    def report(self, full: Array) -> Array:
        """Give the reported parameters, ``(n_draws, n_names)``, px (tau: of the image)."""
        columns = [full[:, : self.size] @ self.to_reported.T]
        if self.infers_sigma:
            columns.append(np.exp(self.log_sigma(full))[:, None])
        if self.prior.infers_tau:
            columns.append(np.exp(full[:, -1:]))
        columns.append(self.noise.report(self.eta(full)))
        return np.concatenate(columns, axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each pixel given the draws, ``(n_draws, n_points)``."""
        return self.log_density(self.residuals(full), full)

    def log_density(self, residuals: Array, full: Array) -> Array:
        """Log density of residuals ``(n_draws, n_points)`` given the draws, of their shape."""
        return self.noise.log_density(residuals, self.log_sigma(full), self.eta(full), self.sd)

    def bad_probability(self, full: Array) -> Array | None:
        """Probability of each point to be bad, averaged over draws, ``(n_points,)``.

        None without a notion of bad points.
        """
        if not self.noise.tells_bad:
            return None
        return self._averaged(lambda block: block.noise.bad_probability, full)

    def weight(self, full: Array) -> Array:
        """Share of a good point's precision that each has, averaged likewise, ``(n_points,)``."""
        return self._averaged(lambda block: block.noise.weight, full)

    def _averaged(
        self, told: Callable[[RobustLinearModel], Callable[..., Any]], full: Array
    ) -> Array:
        """Average over draws what the noise tells of each point; few draws at a time."""
        sums = []
        for block in self.blocks():
            total = np.zeros(len(block.t))
            for part in in_parts(full, len(total), CHUNK):
                given = block.residuals(part), block.log_sigma(part), block.eta(part), block.sd
                total += told(block)(*given).sum(axis=0)
            sums.append(total)
        return np.concatenate(sums) / len(full)
