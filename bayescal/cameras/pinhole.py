r"""The pinhole camera of one view as a function of its parameters, for many draws at once.

World points in the camera's frame are p_c = R (p_w - C); the radial lens and the focal lengths of
a `bayescal.cameras.camera.Camera` take them to pixels. With w^2 = (x_c^2 + y_c^2) / z_c^2

    r = u0 + f_r (x_c / z_c) g,    c = v0 + f_c (y_c / z_c) g,    g = 1 + sum_j k_j w^(p_j),

k_j = (d_j / D) (f / D)^(p_j), f = sqrt(f_r f_c) and D half the image's diagonal, px: d_j is the
displacement in px that term j causes at the image's corner. The powers p_j are 2, 4, 6, ...
("even") or 1, 2, 3, ... ("all", as the thesis writes them). The frame is the points file's, x
right and y the way c grows; a radial lens is the same in it and in its mirror image
(`bayescal.cameras.frames`).

Coordinates theta, in this order: ln f_r, ln f_c; u0, v0 (px); the rotation vector of R
about the stated orientation (rad); the *anchor*, which stands for the camera's position:
the undistorted pixel of the points' centroid (px) and ln(f_r / its depth); d_1, d_2, ...
(px). The data fix the anchor to a fraction of a pixel whatever the focal length is, so that
the posterior is nearly normal in these coordinates where it is a banana in C. Where the
position is held fixed the *free* coordinates lack the anchor, and where a prior knows the position
better than the data do they hold C itself, from an origin, in its place; `full` puts it in.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bayescal.arrays import Array
from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import lens_named
from bayescal.cameras.pose import cross_matrices, left_jacobian, rotations

Radial: TypeAlias = Literal["even", "all"]
POSE = 10  # coordinates before the distortion
ANCHOR = slice(7, 10)


@dataclass(frozen=True, eq=False)
class PinholeGeometry:
    """What predicts pixels: the world points and what the coordinates refer to.

    Attributes
    ----------
    world : Array
        World points, ``(n_points, 3)``, world units.
    orientation : Array
        R at rotation zero, ``(3, 3)``.
    half_diagonal : float
        D, px.
    order : int
        Number of radial terms.
    radial : str
        ``"even"`` or ``"all"``.
    fixed : Array or None
        The camera position where it is held fixed, ``(3,)``, world units.
    origin : Array or None
        From where free coordinates count the position that they hold instead of the anchor,
        ``(3,)``, world units.
    """

    world: Array
    orientation: Array
    half_diagonal: float
    order: int
    radial: Radial = "even"
    fixed: Array | None = None
    origin: Array | None = None

    @property
    def dimension(self) -> int:
        """Number of coordinates that are free."""
        return POSE + self.order - 3 * (self.fixed is not None)

    def full(self, free: Array) -> Array:
        """All coordinates theta of the free ones, ``(n_draws, 10 + order)``."""
        if self.origin is not None:
            return self.to_anchor(free, self.origin + free[:, ANCHOR])
        if self.fixed is None:
            return free
        start = ANCHOR.start
        gap = np.zeros((len(free), 3), dtype=free.dtype)
        theta = np.concatenate([free[:, :start], gap, free[:, start:]], axis=1)
        return self.to_anchor(theta, self.fixed)

    def free(self, theta: Array) -> Array:
        """Give the free ones of all coordinates; inverse of `full`."""
        if self.origin is not None:
            out = theta.copy()
            out[:, ANCHOR] = self.position(theta) - self.origin
            return out
        if self.fixed is None:
            return theta
        return np.delete(theta, np.arange(ANCHOR.start, ANCHOR.stop), axis=1)

    @cached_property
    def centroid(self) -> Array:
        """Mean of the world points, ``(3,)``."""
        return np.asarray(self.world.mean(axis=0))

    @cached_property
    def camera(self) -> Camera:
        """The lens."""
        step = 2 if self.radial == "even" else 1
        return Camera(lens_named("radial", order=self.order, tangential=False, step=step))

    @cached_property
    def powers(self) -> NDArray[np.intp]:
        """Power of the radius in each term of g, ``(order,)``."""
        return np.array(self.camera.lens.powers, dtype=np.intp) - 1

    def rotation(self, theta: Array) -> Array:
        """R of each draw, ``(n_draws, 3, 3)``."""
        return rotations(theta[:, 4:7]) @ self.orientation

    def anchor(self, theta: Array) -> Array:
        """Centroid in the camera's frame, ``(n_draws, 3)``, world units."""
        focal = np.exp(theta[:, :2])
        depth = focal[:, 0] * np.exp(-theta[:, 9])
        sides = (theta[:, 7:9] - theta[:, 2:4]) / focal * depth[:, None]
        return np.column_stack([sides, depth])

    def position(self, theta: Array) -> Array:
        """Camera position C, ``(n_draws, 3)``, world units."""
        turned = np.einsum("mji,mj->mi", self.rotation(theta), self.anchor(theta))
        return np.asarray(self.centroid - turned)

    def log_volume(self, theta: Array) -> Array:
        """Log of |d C / d free|, ``(n_draws,)``: of an anchor depth^3 / (f_r f_c)."""
        if self.origin is not None:
            return np.zeros_like(theta[:, 0])
        log_depth = theta[:, 0] - theta[:, 9]
        return np.asarray(3 * log_depth - theta[:, 0] - theta[:, 1])

    def to_anchor(self, theta: Array, position: Array) -> Array:
        """Coordinates whose anchor belongs to camera positions, ``(n_draws, 3)`` or ``(3,)``.

        Returns
        -------
        Array
            `theta` with its three anchor columns replaced; nan where the centroid is
            behind the camera.
        """
        out = theta.copy()
        away = np.broadcast_to(self.centroid - position, (len(theta), 3))
        p = np.einsum("mij,mj->mi", self.rotation(theta), away)
        focal = np.exp(theta[:, :2])
        with np.errstate(invalid="ignore", divide="ignore"):
            out[:, 7:9] = theta[:, 2:4] + focal * p[:, :2] / p[:, 2:]
            out[:, 9] = theta[:, 0] - np.log(p[:, 2])
        return out

    def project(self, theta: Array) -> tuple[Array, Array]:
        """Pixels of all points.

        Parameters
        ----------
        theta : Array
            All coordinates, ``(n_draws, 10 + order)``; complex ones for complex steps.

        Returns
        -------
        pixels : Array
            r and c, ``(n_draws, 2, n_points)``, px.
        depth : Array
            z_c, ``(n_draws, n_points)``, world units; not positive behind the camera.
        """
        points = self.rotation(theta) @ (self.world - self.centroid).T
        points = points + self.anchor(theta)[:, :, None]
        with np.errstate(over="ignore"):
            k, rays = self.coefficients(theta), np.swapaxes(points, 1, 2)
            pixels = self.camera.pixels(self._intrinsics(theta), k, rays)
        return np.swapaxes(pixels, 1, 2), points[:, 2]

    def _intrinsics(self, theta: Array) -> Array:
        """Focal lengths and principal point, ``(n_draws, 4)``, px."""
        return np.concatenate([np.exp(theta[:, :2]), theta[:, 2:4]], axis=1)

    def coefficients(self, theta: Array) -> Array:
        """k_j of 1 + sum k_j w^p_j, w the radius on the image plane, ``(n_draws, order)``."""
        log_focal = (theta[:, 0] + theta[:, 1]) / 2
        ratio = np.exp(log_focal)[:, None] / self.half_diagonal
        return np.asarray(theta[:, POSE:] / self.half_diagonal * ratio**self.powers)

    def jacobian(self, free: Array) -> Array:
        """Slopes d pixels / d free at one draw ``(dimension,)``, ``(2, n_points, dimension)``."""
        return self.project_with_jacobian(free)[1]

    def project_with_jacobian(self, free: Array) -> tuple[Array, Array]:
        """Pixels at one draw, ``(2, n_points)``, and their `jacobian`."""
        theta = self.full(free[None])
        intrinsics, k = self._intrinsics(theta)[0], self.coefficients(theta)[0]
        rays, slopes = self._rays(theta)
        found = self.camera.jacobian(intrinsics, k, rays)
        out = found.by_ray @ slopes
        out[..., :2] += found.by_intrinsics[..., :2] * intrinsics[:2]  # of their logarithms
        out[..., 2:4] += found.by_intrinsics[..., 2:]
        # k_j = d_j / D (f / D)^p_j holds the focal lengths, too.
        out[..., :2] += (found.by_coefficients @ (k * self.powers / 2))[..., None]
        scale = np.exp(self.powers * (theta[0, :2].mean() - np.log(self.half_diagonal)))
        out[..., self.dimension - self.order :] = found.by_coefficients * scale / self.half_diagonal
        return found.pixels.T, np.swapaxes(out, 0, 1)

    def _rays(self, theta: Array) -> tuple[Array, Array]:
        """Points in the camera's frame, ``(n_points, 3)``, and their slopes by the free ones."""
        turn, shift = self.rotation(theta)[0], self.anchor(theta)[0]
        anchored = self.fixed is None and self.origin is None
        pivot = self.centroid if anchored else self.position(theta)[0]
        arms = (self.world - pivot) @ turn.T
        slopes = np.zeros((*arms.shape, self.dimension))
        slopes[..., 4:7] = -cross_matrices(arms) @ left_jacobian(theta[0, 4:7])
        if self.origin is not None:
            slopes[..., ANCHOR] = -turn
        if not anchored:
            return arms, slopes
        x, y, z = shift
        across, up = z / np.exp(theta[0, :2])  # world units a pixel at the centroid
        slopes[..., :4] = [[0, 0, -across, 0], [y, -y, 0, -up], [z, 0, 0, 0]]
        slopes[..., ANCHOR] = [[across, 0, -x], [0, up, -y], [0, 0, -z]]
        return arms + shift, slopes
