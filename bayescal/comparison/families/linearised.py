"""A joint model about its highest likelihood: what tests and spreads over groups are made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from bayescal.arrays import Array
from bayescal.comparison.families.models import joint_data, moving_axes
from bayescal.comparison.orders.axis import Axis
from bayescal.density.joint_data import JointData
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.points.correspondences import Correspondences

STEP = 1e-30
# What a group leaves of a direction below which only it determines that direction.
ALONE = 1e-8


@dataclass(frozen=True, eq=False)
class Linearised:
    """Residuals of a joint model, and the slopes of its predictions.

    Attributes
    ----------
    names : tuple of str
        Parameters as reported, without those of the noise.
    residuals : Array
        ``(2, n_points)``, px.
    slopes : Array
        Of the predictions over the free parameters, ``(2, n_points, d)``.
    reported : Array
        Slopes of the reported parameters over the free ones, ``(n_names, d)``.
    """

    names: tuple[str, ...]
    data: JointData
    residuals: Array
    slopes: Array
    reported: Array

    @property
    def deviations(self) -> Array:
        """Noise of each pixel at the highest likelihood, ``(2, n_points)``, px."""
        weighted = self.residuals / self.data.deviations
        rss = np.array([e @ e for e in weighted])
        return np.asarray(self.data.likely_sigma(rss)[:, None] * self.data.deviations)

    def spread_over(self, members: Array) -> Array | None:
        """Deviations of the reported parameters by the jackknife over groups, ``(n_names,)``.

        sqrt((G - 1) / G sum (x_g - mean)^2) over refits without each group, to first order in the
        residuals (CV3 of MacKinnon, Nielsen & Webb 2023, J. Appl. Econom. 38, 671): right whatever
        errors the points of a group share.

        Parameters
        ----------
        members : Array
            1 where a point belongs to a group, ``(n_groups, n_points)``.

        Returns
        -------
        Array or None
            None where a parameter rests on one group alone.
        """
        weight = 1 / self.deviations
        design = self.slopes * weight[:, :, None]
        d = design.shape[-1]
        scale = np.linalg.norm(design.reshape(-1, d), axis=0)
        q, r = np.linalg.qr(design.reshape(-1, d) / scale)
        rows, e = q.reshape(2, -1, d), self.residuals * weight
        moved = []
        for group in members.astype(bool):
            own = rows[:, group].reshape(-1, d)
            left, vectors = np.linalg.eigh(np.eye(d) - own.T @ own)
            if left[0] < ALONE:
                return None
            change = vectors @ (vectors.T @ (own.T @ e[:, group].ravel()) / left)
            moved.append(np.linalg.solve(r, change) / scale)
        shifts = np.array(moved) @ self.reported.T
        count = len(shifts)
        return np.asarray(np.sqrt((count - 1) * shifts.var(axis=0)))


def of_pair(
    points: Correspondences,
    axes: tuple[Axis, Axis],
    orders: tuple[int, int],
    position: Array,
    *,
    free: bool,
) -> Linearised:
    """Linearise a pair of orders at a camera position, which is `free` or stated."""
    residuals, designs, moved, maps = [], [], [], []
    names: list[str] = []
    for axis in moving_axes(points, axes, orders):
        data = axis.framed
        designed = axis.design(position + STEP * 1j * np.eye(3))
        design = designed[0].real
        sd = data.deviations
        b, *_ = np.linalg.lstsq(design / sd[:, None], data.t / sd, rcond=None)
        residuals.append(data.t - design @ b)
        designs.append(design)
        moved.append((designed.imag / STEP @ b).T)
        monomials = data.monomials(axis.order)
        maps.append(monomials.lead(axis.order))
        names += [f"{data.symbol}_{powers}" for powers in monomials.suffixes]
    r, c = designs
    slopes = np.stack([np.hstack([r, np.zeros_like(c)]), np.hstack([np.zeros_like(r), c])])
    if free:
        slopes = np.concatenate([slopes, np.stack(moved)], axis=2)
        names += ["position_x", "position_y", "position_z"]
        maps.append(np.eye(3))
    return Linearised(
        tuple(names), joint_data(axes), np.stack(residuals), slopes, block_diag(*maps)
    )


def of_pinhole(model: PinholeModel) -> Linearised:
    """Linearise a pinhole at its fit."""
    geometry, free = model.geometry, model.fit.free
    theta = geometry.full(free + STEP * 1j * np.eye(len(free)))
    columns = [np.exp(theta[:, :2]), theta[:, 2:4], theta[:, 4:7] * (180 / math.pi)]
    if geometry.fixed is None:
        columns.append(geometry.position(theta))
    columns.append(geometry.coefficients(theta))
    reported = np.concatenate(columns, axis=1).imag.T / STEP
    names = model.names[: len(reported)]
    return Linearised(names, model.data, model.fit.residuals, geometry.jacobian(free), reported)
