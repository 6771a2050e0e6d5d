"""Cameras with known parameters, and the pixels they take."""

from __future__ import annotations

import numpy as np

import bayescal as bc
from bayescal.cameras.pinhole import PinholeGeometry
from bayescal.density.joint_data import JointData
from bayescal.noise.level import NoiseLevel
from bayescal.points.camera import StatedCamera
from bayescal.points.correspondences import Correspondences
from bayescal.points.setup import Setup
from bayescal.prior.camera import pinhole_prior
from tests.helpers.chapter_three import distort, project, rotation_matrix, world_to_camera

INFERRED = (NoiseLevel.inferred(), NoiseLevel.inferred())


def pixels(world, focal, centre, rotation, position, k=(), radial="even"):
    """Pixels of a pinhole, by the steps of the thesis's chapter 3 one after another."""
    translation = -rotation_matrix(rotation) @ np.asarray(position, dtype=float)
    image = distort(project(world_to_camera(world, rotation, translation)), k, radial)
    return np.asarray(centre) + np.asarray(focal) * image


# Like Tsai's non-coplanar set: five planes of 60 points, a long lens turned by 30 degrees.
TURNED = {
    "focal": (3043.0, 3042.0),
    "centre": (300.0, 200.0),
    "rotation": (0.5235, 0.0175, 0.035),
    "position": (138.0, -926.0, -1768.0),
    "k": (3.0,),
}


def turned_points(noise: float, seed: int = 5, truth=None) -> Correspondences:
    """300 points that a turned camera sees, with noise of so many px."""
    truth = TURNED if truth is None else truth
    x, y, z = np.meshgrid(np.arange(10.0, 210, 20), np.arange(10.0, 250, 40), np.arange(5) * 40.0)
    world = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    exact = pixels(world, **truth)
    noisy = exact + np.random.default_rng(seed).normal(0, noise, exact.shape)
    camera = StatedCamera(position_sd=(50.0, 50.0, 50.0), orientation=(30.0, 0.0, 0.0))
    setup = Setup(position=(120.0, -900.0, -1800.0), width=576.0, height=384.0, camera=camera)
    return bc.Correspondences.from_arrays(world, noisy, setup=setup)


def problem(points, order, radial="even", *, fixed=False, levels=INFERRED, tau=None):
    """Geometry, prior and data of a pinhole."""
    prior = pinhole_prior(points, tau)
    where = prior.position.mean if fixed else None
    made = PinholeGeometry(
        points.world, prior.orientation, prior.half_diagonal, order, radial, where
    )
    data = JointData(np.stack([points.pixel(a) for a in "rc"]), (None, None), levels)
    return made, prior, data
