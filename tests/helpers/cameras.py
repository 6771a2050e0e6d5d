"""Cameras with known parameters, and the pixels they take."""

from __future__ import annotations

import numpy as np

from bayescal.cameras.pinhole import PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.noise.level import NoiseLevel
from bayescal.points.correspondences import Correspondences
from bayescal.prior.camera import pinhole_prior
from scripts.validation import turned_camera
from scripts.validation.turned_camera import TURNED
from tests.helpers.chapter_three import distort, project, rotation_matrix, world_to_camera

INFERRED = (NoiseLevel.inferred(), NoiseLevel.inferred())


def pixels(world, focal, centre, rotation, position, k=(), radial="even"):
    """Pixels of a pinhole, by the steps of the thesis's chapter 3 one after another."""
    translation = -rotation_matrix(rotation) @ np.asarray(position, dtype=float)
    image = distort(project(world_to_camera(world, rotation, translation)), k, radial)
    return np.asarray(centre) + np.asarray(focal) * image


def turned_points(noise: float, seed: int = 5, truth=TURNED) -> Correspondences:
    """300 points that a turned camera sees, projected by those steps."""
    return turned_camera.turned_points(noise, seed, truth, pixels)


def problem(points, order, radial="even", *, fixed=False, levels=INFERRED, tau=None):
    """Geometry, prior and data of a pinhole."""
    prior = pinhole_prior(points, tau)
    where = prior.position.mean if fixed else None
    made = PinholeGeometry(
        points.world, prior.orientation, prior.half_diagonal, order, radial, where
    )
    data = JointData(np.stack([points.pixel(a) for a in "rc"]), (None, None), levels)
    return made, prior, data
