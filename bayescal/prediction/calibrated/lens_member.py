"""A member whose mapping is a lens, with a pose where it has one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from bayescal.arrays import Array
from bayescal.cameras.camera import Camera
from bayescal.cameras.lenses import Lens, lens_named
from bayescal.cameras.pose import rotations
from bayescal.prediction.calibrated.alignment import absorbed_turns
from bayescal.prediction.calibrated.hull import within
from bayescal.prediction.calibrated.members import (
    Ahead,
    BoolArray,
    Estimate,
    Parameters,
    Rays,
    Solutions,
)
from bayescal.prediction.calibrated.noise import NewNoise


@dataclass(frozen=True, eq=False)
class LensMember:
    """A lens, with a pose where it has one.

    Parameters: ln fx, ln fy; cx, cy (px); the lens's coefficients; then the pose: a turn from
    `turn` on the camera's side (rad), the undistorted pixel of `anchor` (px), ln of its depth over
    fx. The data fix these to about a pixel each whatever the focal length is. A lens of many views
    has of these the turn that their poses absorb (`bayescal.prediction.calibrated.alignment`).

    Attributes
    ----------
    lens_options : dict
        As `bayescal.cameras.lenses.lens_named` takes them.
    turn : Array or None
        Rotation matrix of the pose's mean, ``(3, 3)``; None where parameters hold no turn.
    anchor : Array or None
        A world point among those calibrated with, ``(3,)``; None without a place in the world.
    hull : Array
        Corners of the calibration pixels' hull, ``(m, 2)``, px.
    """

    name: str
    lens_name: str
    lens_options: dict[str, int | bool]
    turn: Array | None
    anchor: Array | None
    hull: Array
    parameters: Parameters
    noise: NewNoise
    estimate: Estimate | None = None
    linear: ClassVar[None] = None  # pixels are not, of the focal length and the pose

    @cached_property
    def lens(self) -> Lens:
        """The lens itself."""
        return lens_named(self.lens_name, **self.lens_options)

    @property
    def _camera(self) -> Camera:
        return Camera(self.lens)

    @property
    def _mean(self) -> Array:
        return self.parameters.mean[None]

    @property
    def posed(self) -> bool:
        """Whether it has a place in the world; else points are in the camera's frame."""
        return self.anchor is not None

    @property
    def n_lens(self) -> int:
        """Number of parameters before the pose."""
        return 4 + len(self.lens.names)

    @property
    def n_free(self) -> int:
        """How many parameters move predictions: not the turn that poses absorb."""
        return len(self._mean[0]) if self.posed else self.n_lens

    def intrinsics(self, theta: Array) -> tuple[Array, Array]:
        """Intrinsics fx, fy, cx, cy ``(m, 4)``, px, and coefficients ``(m, K)``."""
        focal = np.exp(theta[:, :2])
        return np.concatenate([focal, theta[:, 2:4]], axis=1), theta[:, 4 : self.n_lens]

    def pose(self, theta: Array) -> tuple[Array, Array]:
        """Rotation matrices ``(m, 3, 3)`` and translations ``(m, 3)``: p = R X + t."""
        at = self.n_lens
        if self.turn is None:
            return np.broadcast_to(np.eye(3), (len(theta), 3, 3)), np.zeros((len(theta), 3))
        matrix = rotations(theta[:, at : at + 3]) @ self.turn
        if self.anchor is None:
            return matrix, np.zeros((len(theta), 3))
        focal = np.exp(theta[:, :2])
        depth = np.exp(theta[:, 0] + theta[:, at + 5])
        sides = (theta[:, at + 3 : at + 5] - theta[:, 2:4]) / focal * depth[:, None]
        return matrix, np.column_stack([sides, depth]) - matrix @ self.anchor

    def project(self, theta: Array, world: Array) -> tuple[Array, BoolArray]:
        """Pixels of points, and which the lens sees."""
        (matrix, t), (intrinsics, k) = self.pose(theta), self.intrinsics(theta)
        away = world @ np.swapaxes(matrix, 1, 2) + t[:, None, :]
        with np.errstate(all="ignore"):
            pixels = self._camera.pixels(intrinsics, k, away)
            seen = self.lens.seen(away, k) & np.isfinite(pixels).all(axis=-1)
        return np.where(seen[..., None], pixels, 0.0), seen

    def project_with_slopes(self, theta: Array, world: Array) -> tuple[Array, Array, BoolArray]:
        """Pixels, their derivatives by points, and which the lens sees."""
        (matrix, t), (intrinsics, k) = self.pose(theta), self.intrinsics(theta)
        away = world @ np.swapaxes(matrix, 1, 2) + t[:, None, :]
        with np.errstate(all="ignore"):
            found = self._camera.jacobian(intrinsics, k, away)
            seen = self.lens.seen(away, k) & np.isfinite(found.pixels).all(axis=-1)
        return found.pixels, found.by_ray @ matrix[:, None], seen

    def covered(self, world: Array) -> BoolArray:
        """Whether points appear inside the hull of the calibration pixels."""
        pixels, seen = self.project(self._mean, world)
        return np.asarray(seen[0] & within(self.hull, pixels[0]))

    def solutions(self, pixels: Array) -> Solutions:
        """Solve pixels: a lens has one ray of each, or none."""
        found = self.rays(self._mean, pixels[None], None).found[0]
        return Solutions(None, found.astype(np.intp), within(self.hull, pixels))

    def continued(self, pixels: Array) -> Solutions:
        """Solve pixels: a lens goes on as it is."""
        return Solutions(None, np.ones(len(pixels), dtype=np.intp), within(self.hull, pixels))

    def rays(self, theta: Array, pixels: Array, start: Array | None) -> Rays:  # noqa: ARG002
        """Lines of sight; a lens needs nothing to start from."""
        intrinsics, k = self.intrinsics(theta)
        undistorted = self._camera.rays(intrinsics, k, pixels)
        unit = np.where(undistorted.found[..., None], undistorted.rays, 0.0)
        unit[..., 2] = np.where(undistorted.found, unit[..., 2], 1.0)
        matrix, t = self.pose(theta)
        return Rays(-np.einsum("mji,mj->mi", matrix, t), unit @ matrix, undistorted.found)

    @property
    def ahead(self) -> Ahead:
        """The principal point and the focal lengths."""
        numbers = self.intrinsics(self._mean)[0][0]
        return Ahead(numbers[2:], numbers[:2], True)

    def directions(self, pixels: Array) -> Array:
        """Directions of pixels in the lens's own frame."""
        intrinsics, k = self.intrinsics(self._mean)
        return self._camera.rays(intrinsics[0], k[0], pixels).rays

    def of_directions(self, directions: Array) -> tuple[Array, BoolArray]:
        """Pixels of directions in the lens's own frame, and whether it sees them."""
        intrinsics, k = self.intrinsics(self._mean)
        seen = self.lens.seen(directions, k[0])
        return self._camera.pixels(intrinsics[0], k[0], directions), seen

    def aligned(self, rays: Array, pixels: Array) -> LensMember:
        """Turn each draw to see rays closest to pixels, where no pose fixes it."""
        if self.posed:
            return self
        theta = self.parameters.draws[:, : self.n_lens]
        turns = absorbed_turns(self.lens, *self.intrinsics(theta), rays, pixels)
        kept = Parameters.of_draws(np.concatenate([theta, turns], axis=1))
        return replace(self, turn=np.eye(3), parameters=kept)

    def by_data(self, rng: np.random.Generator) -> LensMember:
        """Take what the data alone say, where it is known; a frame that poses absorb is left."""
        if self.estimate is None:
            return self
        turn = self.turn if self.posed else None
        return replace(self, turn=turn, parameters=self.estimate.parameters(rng))

    def in_own_frame(self) -> LensMember:
        """Leave the turn out, where no pose fixes the frame."""
        if self.posed:
            return self
        kept, n = self.parameters, self.n_lens
        own = Parameters(kept.mean[:n], kept.root[:n], kept.draws[:, :n], kept.exact)
        return replace(self, turn=None, parameters=own)

    def plain(self) -> dict[str, Any]:
        """Name the lens and its place."""
        return {
            "lens": self.lens_name,
            "options": self.lens_options,
            "turn": None if self.turn is None else self.turn.tolist(),
            "anchor": None if self.anchor is None else self.anchor.tolist(),
        }
