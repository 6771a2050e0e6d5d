r"""What the noise of a picture and the calibration make of a pose found in it, linearly.

The pose's residuals are r = J s + S u + e: s its own step, u the calibration's parameters in
one-sd steps, e the noise. The pose is by plain least squares, so that its covariance is
A (N + S S') A' with A = J^+ and N that of e; chi-squared is the smallest
(r - J s - S u)' N^-1 (r - J s - S u) + u' u, which has 2 n - 6 degrees of freedom given sigma.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import gammaincc

from bayescal.arrays import Array
from bayescal.prediction.calibrated.members import Member
from bayescal.prediction.picture import Picture
from bayescal.prediction.placing import Placed, sensitivity


@dataclass(frozen=True, eq=False)
class Propagated:
    """Covariances of a pose by source, and what its residuals say.

    Attributes
    ----------
    noise, lens : Array
        ``(6, 6)``, world units and rad.
    p_value : float or None
        Averaged over what is known of the noise; None without degrees of freedom.
    """

    noise: Array
    lens: Array
    chi2: float
    p_value: float | None


def propagated(
    member: Member, at: Placed, points: Array, pixels: Array, picture: Picture, seed: int
) -> Propagated:
    """Propagate about a pose found by least squares.

    Parameters
    ----------
    at : Placed
        One pose.
    points : Array
        Of the target, ``(n, 3)``, world units.
    pixels : Array
        Where each is seen, ``(n, 2)``, px.
    seed : int
        Of the simulation that robust noise needs, and noise that neighbours share.
    """
    kept, scale = member.parameters, picture.scale
    miss, slope, _ = sensitivity(member, kept.mean[None], points, pixels[None], scale, at)
    world = points @ at.rotation[0].T + at.position[0]
    moved, _ = member.project(kept.steps, world)
    d = (len(kept.steps) - 1) // 2
    steps = ((moved[1 : 1 + d] - moved[1 + d :]) / 2 / scale).reshape(d, -1).T
    carried = np.linalg.pinv(slope[0])
    root = picture.root(points)
    noise = carried if root is None else _by_point(root.T, carried.T).T
    lens = carried @ steps
    system = np.zeros((len(steps) + d, 6 + d))
    system[: len(steps)] = _whitened(root, np.column_stack([slope[0], steps]))
    system[len(steps) :, 6:] = np.eye(d)

    def chi2(residuals: Array) -> Array:
        padded = np.zeros((len(system), residuals.shape[1]))
        padded[: len(residuals)] = _whitened(root, residuals)
        left = padded - system @ np.linalg.lstsq(system, padded)[0]
        return np.asarray((left**2).sum(axis=0))

    found, dof = float(chi2(miss[0, :, None])[0]), miss.size - 6
    p_value = None
    if dof > 0 and picture.gaussian:
        p_value = float(gammaincc(dof / 2, found / 2 / picture.variances).mean())
    elif dof > 0:
        drawn = member.project(kept.draws, world)[0] - member.project(kept.mean[None], world)[0]
        drawn = drawn + picture.draw(np.random.default_rng([seed, 3]), points)
        by_chance = chi2((drawn / scale).reshape(len(drawn), -1).T)
        p_value = float((1 + (by_chance >= found).sum()) / (1 + len(drawn)))
    return Propagated(noise @ noise.T, lens @ lens.T, found, p_value)


def _by_point(matrix: Array, values: Array) -> Array:
    """Multiply over the points of values ``(2 n, k)``: r and c alike."""
    return np.asarray((matrix @ values.reshape(len(matrix), -1)).reshape(values.shape))


def _whitened(root: Array | None, values: Array) -> Array:
    if root is None:
        return values
    found = solve_triangular(root, values.reshape(len(root), -1), lower=True)
    return np.asarray(found.reshape(values.shape))
