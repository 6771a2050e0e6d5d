r"""A linear family whose camera position is not known: coefficients eliminated exactly.

At a given position every coefficient, sigma and tau integrates out in closed form, axis by
axis (`bayescal.inference.evidence`); what is left to sample are the position's three numbers.
The basis keeps the domain of the stated position, so that the prior of the amplitudes, which
is stated in px at the edges of the domain, means the same wherever the camera is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bayescal.arrays import Array
from bayescal.inference.evidence import (
    LOG_2PI,
    Projection,
    Reduced,
    log_evidences,
    log_joint,
    tau_rule,
)
from bayescal.inference.optimum import Mode
from bayescal.inference.quadrature import Accuracy
from bayescal.inference.t_mixture import cholesky
from bayescal.models.camera_prior import PositionPrior
from bayescal.models.linear import AxisData
from bayescal.models.noise.level import NoiseLevel
from bayescal.models.priors import CoefficientPrior
from bayescal.models.strength import Strength

CHUNK = 4_000_000  # numbers held at once
GIBBS = 2  # sweeps that make the quadrature's discrete sigma and tau continuous
NEWTON = 3
# A few thousandths of a nat, tens of thousands of times.
QUICK = Accuracy(resolve=8.0, drop=11.0, panel_nodes=9, tau_nodes=17, panels=10)


@dataclass(frozen=True, eq=False)
class MovingAxis:
    """One axis of a linear family as a function of the camera position.

    Attributes
    ----------
    data : AxisData
        At the stated position; its basis stays.
    world : Array
        World points, ``(n_points, 3)``, world units.
    column : int
        Coordinate of the axis's own regressor: 0 for r, 1 for c.
    order : int
    noise : NoiseLevel
    prior : CoefficientPrior
    """

    data: AxisData
    world: Array
    column: int
    order: int
    noise: NoiseLevel
    prior: CoefficientPrior

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return self.data.columns(self.order)

    def design(self, position: Array) -> Array:
        """Design matrices at positions ``(m, 3)``, ``(m, n_points, size)``."""
        away = self.world - position[:, None, :]
        depth = away[:, :, 2]
        x = away[:, :, self.column] / depth
        other = None if self.data.other is None else (away[:, :, 1 - self.column] / depth).ravel()
        moved = replace(self.framed, x=x.ravel(), other=other)
        return moved.design(self.order).reshape(*x.shape, self.size)

    @cached_property
    def framed(self) -> AxisData:
        """The axis with its basis held."""
        first = (self.data.domain,)
        return replace(
            self.data, frame=first if self.data.other is None else (*first, self.data.across)
        )

    def reduced(self, position: Array) -> Reduced:
        """Weighted least squares at positions ``(m, 3)``."""
        m, n, p = len(position), len(self.world), self.size
        t = np.broadcast_to(self.data.t[:, None], (m, n, 1))
        augmented = np.concatenate([self.design(position), t], axis=2)
        log_sd = 0.0
        if self.data.sd is not None:
            augmented /= self.data.sd[:, None]
            log_sd = float(np.log(self.data.sd).sum())
        triangle = np.linalg.qr(augmented, mode="r")
        ones = np.ones(m)
        rss = triangle[:, p, p] ** 2 if n > p else 0 * ones
        return Reduced(triangle[:, :p, :p], triangle[:, :p, p], rss, n * ones, log_sd * ones)

    def draw(self, rng: np.random.Generator, position: Array) -> tuple[Array, Array, Array]:
        """Draw amplitudes ``(m, size)``, ln sigma and ln tau ``(m,)`` given positions."""
        data = self.reduced(position)
        rule, log_tau = tau_rule(self.prior, QUICK)
        projection = Projection.of(data, self.prior, log_tau)
        sigma_rule, values = log_joint(data, projection, self.noise, self.prior, QUICK)
        weights = np.log(rule.weights[:, None] * sigma_rule.weights)
        flat = (values + weights).reshape(len(position), -1)
        pick = np.argmax(flat + rng.gumbel(size=flat.shape), axis=1)
        i, j = np.divmod(pick, len(sigma_rule.nodes))
        known = self.noise.value
        log_sigma = sigma_rule.nodes[j] if known is None else np.full(len(position), np.log(known))
        tau = log_tau[i]
        for _ in range(GIBBS):
            amplitudes = self._amplitudes(rng, data, log_sigma, tau)
            if self.noise.bounds is not None:
                misfit = data.qt - np.einsum("mij,mj->mi", data.r, amplitudes)
                rss = data.rss + (misfit**2).sum(axis=1)
                log_sigma = Strength(self.noise.log_bounds, len(self.world)).draw(rss, rng)
            if self.prior.infers_tau:
                strong = self.prior.scaled
                z = (amplitudes - self.prior.mean)[:, strong] / self.prior.sd[strong]
                strength = Strength(self.prior.log_tau_bounds, int(strong.sum()))
                tau = strength.draw((z**2).sum(axis=1), rng)
        return self._amplitudes(rng, data, log_sigma, tau), log_sigma, tau

    def _amplitudes(
        self, rng: np.random.Generator, data: Reduced, log_sigma: Array, log_tau: Array
    ) -> Array:
        """Draw from the normal given sigma and tau (Bishop 2006, 3.3)."""
        s = self.prior.deviations(log_tau)
        u, d, vt = np.linalg.svd(data.r * s[:, None, :])
        w = np.einsum("mji,mj->mi", u, data.qt - data.r @ self.prior.mean)
        variance = np.exp(2 * log_sigma)[:, None]
        total = variance + d**2
        a = d * w / total + np.sqrt(variance / total) * rng.standard_normal(w.shape)
        return np.asarray(self.prior.mean + s * np.einsum("mji,mj->mi", vt, a))

    def log_likelihood(self, position: Array, amplitudes: Array, log_sigma: Array) -> Array:
        """Log density of each pixel, ``(m, n_points)``."""
        prediction = np.einsum("mnp,mp->mn", self.design(position), amplitudes)
        log_scale = log_sigma[:, None]
        if self.data.sd is not None:
            log_scale = log_scale + np.log(self.data.sd)
        z = (self.data.t - prediction) * np.exp(-log_scale)
        return np.asarray(-(z**2 + LOG_2PI) / 2 - log_scale)


@dataclass(frozen=True, eq=False)
class FreePositionModel:
    """Both axes of a linear family at a camera position that is inferred.

    Attributes
    ----------
    axes : tuple of MovingAxis
        Of r and of c.
    prior : PositionPrior
    start : Array
        Where the likelihood is highest, ``(3,)``, world units.
    """

    axes: tuple[MovingAxis, MovingAxis]
    prior: PositionPrior
    start: Array

    @property
    def dimension(self) -> int:
        """Three: the position in units of its prior's deviations from the start."""
        return 3

    @property
    def names(self) -> tuple[str, ...]:
        """Coefficients, sigma and tau of each axis, then the position."""
        out: list[str] = []
        for axis in self.axes:
            suffixes = axis.data.monomials(axis.order).suffixes
            out += [f"{axis.data.symbol}_{powers}" for powers in suffixes]
            out += [f"{axis.noise.parameter}_{axis.data.axis}"] * (axis.noise.value is None)
            out += [f"tau_{axis.data.axis}"] * axis.prior.infers_tau
        return (*out, "position_x", "position_y", "position_z")

    def position(self, theta: Array) -> Array:
        """Camera positions of sampled coordinates, ``(n_draws, 3)``, world units."""
        return self.start + theta[:, :3] * self.prior.sd

    def possible(self, position: Array) -> Array:
        """Whether every point stays on the side of the camera it is stated to be on."""
        z = self.axes[0].world[:, 2]
        stated = np.sign(z - self.prior.mean[2])
        return np.asarray((np.sign(z - position[:, 2:]) == stated).all(axis=1))

    def log_prob(self, theta: Array) -> Array:
        """Log evidence of both axes at a position, times its prior, ``(n_draws,)``."""
        position = self.position(theta)
        out = np.full(len(theta), -np.inf)
        inside = np.flatnonzero(self.possible(position))
        step = max(1, CHUNK // (len(self.axes[0].world) * (self.axes[0].size + 1)))
        for first in range(0, len(inside), step):
            part = inside[first : first + step]
            out[part] = self.prior.log_density(position[part]) + np.log(self.prior.sd).sum()
            for axis in self.axes:
                out[part] += log_evidences(
                    axis.reduced(position[part]), axis.noise, axis.prior, QUICK
                )
        return np.where(np.isfinite(out), out, -np.inf)

    def starts(self) -> Array:
        """Give the likelihood's maximum and the stated position, ``(2, 3)``."""
        return np.stack([np.zeros(3), (self.prior.mean - self.start) / self.prior.sd])

    def complete(self, theta: Array, rng: np.random.Generator) -> Array:
        """Draw coefficients, sigma and tau of both axes given the position."""
        columns = [theta]
        for axis in self.axes:
            amplitudes, log_sigma, log_tau = axis.draw(rng, self.position(theta))
            columns += [amplitudes, log_sigma[:, None], log_tau[:, None]]
        return np.concatenate(columns, axis=1)

    def report(self, full: Array) -> Array:
        """Monomial coefficients (px), sigma (px), tau and position, ``(n_draws, n_names)``."""
        columns = []
        for axis, (amplitudes, log_sigma, log_tau) in zip(
            self.axes, self._parts(full), strict=True
        ):
            columns.append(amplitudes @ axis.framed.monomials(axis.order).lead(axis.order).T)
            if axis.noise.value is None:
                columns.append(np.exp(log_sigma)[:, None])
            if axis.prior.infers_tau:
                columns.append(np.exp(log_tau)[:, None])
        return np.concatenate([*columns, self.position(full)], axis=1)

    def log_likelihood(self, full: Array) -> Array:
        """Log density of each point, r and c together, ``(n_draws, n_points)``."""
        position, total = self.position(full), np.zeros(1)
        for axis, (amplitudes, log_sigma, _) in zip(self.axes, self._parts(full), strict=True):
            total = total + axis.log_likelihood(position, amplitudes, log_sigma)
        return np.asarray(total)

    def _parts(self, full: Array) -> list[tuple[Array, Array, Array]]:
        out, at = [], 3
        for axis in self.axes:
            p = axis.size
            out.append((full[:, at : at + p], full[:, at + p], full[:, at + p + 1]))
            at += p + 2
        return out


def best_position(
    axes: Sequence[MovingAxis], prior: PositionPrior, log_likelihood: Callable[[Array], float]
) -> tuple[Array, float]:
    """Position of highest likelihood, the coefficients eliminated (Golub & Pereyra 1973).

    Parameters
    ----------
    axes : sequence of MovingAxis
    prior : PositionPrior
        Where to start, and how far apart to look.
    log_likelihood : callable
        From the axes' weighted sums of squares to the maximised log likelihood.

    Returns
    -------
    position : Array
        ``(3,)``, world units.
    log_likelihood : float
    """
    from scipy.optimize import minimize

    z, mean, sd = axes[0].world[:, 2], prior.mean, prior.sd
    side = np.sign(z - mean[2])

    def objective(u: Array) -> tuple[float, Array]:
        position = mean + u * sd
        if (np.sign(z - position[2]) != side).any():
            return 1e300, np.zeros(3)
        rss, slopes = zip(*(profile(axis, position) for axis in axes), strict=True)
        values = np.array(rss)
        top = log_likelihood(values)
        # ln L depends on each sum of squares q as -n/2 ln q or -q / (2 sigma^2).
        slope = np.zeros(3)
        for axis, q, d in zip(axes, rss, slopes, strict=True):
            known = axis.noise.value
            slope += d * (len(z) / (2 * q) if known is None else 1 / (2 * known**2))
        return -top, slope * sd

    found = minimize(objective, np.zeros(3), jac=True, method="BFGS", options={"gtol": 1e-6})
    return mean + found.x * sd, -float(found.fun)


def profile(axis: MovingAxis, position: Array) -> tuple[float, Array]:
    """Weighted sum of squares at the best coefficients, and its slope in the position.

    The slope is -2 e' (dX/dposition) b, e the residuals: those in the coefficients vanish
    (Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413).
    """
    step = 1e-30
    moved = axis.design(position + step * 1j * np.eye(3))
    design, slopes = moved[0].real, moved.imag / step
    sd = np.ones(len(design)) if axis.data.sd is None else axis.data.sd
    b, *_ = np.linalg.lstsq(design / sd[:, None], axis.data.t / sd, rcond=None)
    e = (axis.data.t - design @ b) / sd
    return float(e @ e), np.array([-2 * e @ ((dx @ b) / sd) for dx in slopes])


def position_mode(model: FreePositionModel) -> Mode:
    """Laplace approximation of the position's posterior, by Newton steps.

    The steps of the differences come from the slopes of the sums of squares; some forty
    evaluations where a search that knows nothing takes hundreds.
    """
    step = np.zeros(3)
    for axis in model.axes:
        rss, _ = profile(axis, model.start)
        n, known = len(axis.world), axis.noise.value
        sigma2 = rss / n if known is None else known**2
        step += np.array([_curvature(axis, model.start, e) for e in np.eye(3)]) / sigma2
    step = 0.3 / np.sqrt(step + model.prior.sd**-2) / model.prior.sd
    theta = np.zeros(3)
    for _ in range(NEWTON):
        centre, slope, hessian = _differences(model, theta, step)
        values, vectors = np.linalg.eigh(hessian)
        values = np.maximum(values, 1e-2)
        move = vectors @ (vectors.T @ slope / values) * step
        root = cholesky((step[:, None] * vectors / values) @ (step[:, None] * vectors).T)
        if float(model.log_prob((theta + move)[None])[0]) < centre:
            break
        theta = theta + move
    return Mode(theta, float(model.log_prob(theta[None])[0]), root)


def _curvature(axis: MovingAxis, position: Array, direction: Array) -> float:
    """Sum of squares that a unit step of the position adds, the coefficients following."""
    moved = axis.design(position + 1e-30j * direction[None])[0]
    sd = np.ones(len(moved)) if axis.data.sd is None else axis.data.sd
    design, slope = moved.real / sd[:, None], moved.imag * 1e30 / sd[:, None]
    b, *_ = np.linalg.lstsq(design, axis.data.t / sd, rcond=None)
    change = slope @ b
    c, *_ = np.linalg.lstsq(design, change, rcond=None)
    return float(((change - design @ c) ** 2).sum())


def _differences(model: FreePositionModel, theta: Array, step: Array) -> tuple[float, Array, Array]:
    """Log density, its slope and minus its curvature, per step."""
    unit = np.diag(step)
    i, j = np.triu_indices(3, 1)
    corners = [a * unit[i] + b * unit[j] for a in (1, -1) for b in (1, -1)]
    values = model.log_prob(theta + np.concatenate([np.zeros((1, 3)), unit, -unit, *corners]))
    centre, up, down = values[0], values[1:4], values[4:7]
    pp, pm, mp, mm = values[7:].reshape(4, 3)
    hessian = np.diag(2 * centre - up - down)
    hessian[i, j] = hessian[j, i] = (pm + mp - pp - mm) / 4
    return float(centre), (up - down) / 2, np.nan_to_num(hessian)
