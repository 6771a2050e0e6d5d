"""A fitted pinhole as OpenCV's camera: matrix, distortion and pose, with their covariance.

Where c is counted from the image's bottom the export counts rows from the top again, and takes
world points with y negated (`bayescal.cameras.frames`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.cameras.frames import Frame
from bayescal.cameras.pinhole import ANCHOR, POSE
from bayescal.cameras.pose import rotation_vectors
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.key import PINHOLE
from bayescal.density.pinholes.pinhole import PinholeModel
from bayescal.errors import InputError
from bayescal.files import write_whole
from bayescal.points.setup import Setup
from bayescal.report.cameras.opencv_storage import HEADER, list_lines, matrix_lines

LARGEST_ORDER = 3  # k1, k2, k3
NEGATED = "y negated: (x, -y, z), since rows are counted from the top here"
KEPT = "as in the points file"


@dataclass(frozen=True, eq=False)
class OpenCVCamera:
    """What ``cv2.projectPoints`` takes, and how sure it is.

    Attributes
    ----------
    matrix : Array
        fx, fy, cx, cy in place, ``(3, 3)``, px.
    distortion : Array
        k1, k2, p1, p2, k3, ``(5,)``; p1 and p2 are 0.
    rotation, translation : Array
        rvec (rad) and tvec (world units), ``(3,)``.
    names : tuple of str
        Parameters of the covariance.
    covariance : Array
        Posterior covariance of the parameters, ``(d, d)``.
    negates_y : bool
        Whether world points go in with y negated.
    size : tuple
        Width and height of the image, px; None where not known.
    sound : bool
        Whether its draws converged and its evidence can be trusted.
    """

    matrix: Array
    distortion: Array
    rotation: Array
    translation: Array
    names: tuple[str, ...]
    covariance: Array
    negates_y: bool
    size: tuple[float | None, float | None]
    sound: bool

    def __str__(self) -> str:
        """Text for ``cv2.FileStorage``, YAML."""
        lines = list(HEADER)
        lines += [
            f"{name}: {round(value)}"
            for name, value in zip(("image_width", "image_height"), self.size, strict=True)
            if value is not None
        ]
        lines.append(f"draws_converged: {int(self.sound)}")
        lines.append(f'world_points: "{NEGATED if self.negates_y else KEPT}"')
        for name, array in (
            ("camera_matrix", self.matrix),
            ("distortion_coefficients", self.distortion[None]),
            ("rotation_vector", self.rotation[:, None]),
            ("translation_vector", self.translation[:, None]),
            ("standard_deviations", np.sqrt(np.diag(self.covariance))[:, None]),
            ("covariance", self.covariance),
        ):
            lines += matrix_lines(name, array)
        return "\n".join([*lines, *list_lines("parameters", self.names)]) + "\n"


def check_opencv(family: str, order: int, radial: str) -> None:
    """Refuse what OpenCV's camera can't be, before anything is sampled.

    Raises
    ------
    InputError
    """
    if family != PINHOLE:
        raise InputError(f"OpenCV's camera is a pinhole, not {family}: add --family pinhole")
    if order > LARGEST_ORDER or (order and radial != "even"):
        raise InputError(
            "OpenCV's camera has up to three radial coefficients, in even powers of the radius: "
            f"order 0 to {LARGEST_ORDER} with --radial even"
        )


def opencv_camera(found: FamilyComparison) -> OpenCVCamera:
    """Give the most probable model of a comparison, a pinhole, as OpenCV's camera.

    The camera is that of the posterior's mean in the geometry's free coordinates.

    Parameters
    ----------
    found : FamilyComparison
        As of `bayescal.fit_family`.

    Returns
    -------
    OpenCVCamera

    Raises
    ------
    InputError
        Where the model is no pinhole, or its distortion none of OpenCV's.
    """
    best = found.best
    check_opencv(best.key.family, best.key.orders[0], found.request.radial)
    posterior, setup = best.posterior, found.points.setup
    model = best.camera
    assert posterior is not None, "pinholes are sampled"
    assert model is not None, "it is one"
    theta = model.coordinates(posterior.full.reshape(-1, posterior.full.shape[2]))
    # In the free coordinates the posterior is nearly normal; a position held fixed stays so.
    middle = model.geometry.full(model.geometry.free(theta).mean(axis=0, keepdims=True))
    draws, mean = (_parameters(model, t, setup) for t in (theta, middle))
    # A rotation vector and that of the full turn less are the same: the one near the mean's.
    turn = draws[:, 4:7]
    angle = np.linalg.norm(turn, axis=1, keepdims=True)
    other = turn - turn * (2 * np.pi / np.maximum(angle, 1e-12))
    nearer = np.linalg.norm(other - mean[:, 4:7], axis=1) < np.linalg.norm(
        turn - mean[:, 4:7], axis=1
    )
    draws[nearer, 4:7] = other[nearer]
    fx, fy, cx, cy = mean[0, :4].tolist()
    k = np.zeros(LARGEST_ORDER)
    order = best.key.orders[0]
    k[:order] = mean[0, POSE:]
    inferred = np.ones(draws.shape[1], dtype=bool)
    if model.geometry.fixed is not None:  # t follows from R where the position is stated
        inferred[ANCHOR] = False
    every = ("fx", "fy", "cx", "cy", "rx", "ry", "rz", "tx", "ty", "tz")
    names = (*every, *(f"k{j + 1}" for j in range(order)))
    kept = [name for name, known in zip(names, inferred, strict=True) if known]
    return OpenCVCamera(
        frozen([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]),
        frozen([k[0], k[1], 0, 0, k[2]]),
        frozen(mean[0, 4:7]),
        frozen(mean[0, ANCHOR]),
        tuple(kept),
        frozen(np.cov(draws[:, inferred].T)),
        setup.c_from_bottom,
        (setup.width, setup.height),
        best.sound,
    )


def _parameters(model: PinholeModel, theta: Array, setup: Setup) -> Array:
    """fx, fy, cx, cy, rvec, tvec and k of draws, ``(n_draws, 10 + order)``."""
    geometry = model.geometry
    rotation, position = geometry.rotation(theta), geometry.position(theta)
    frame = Frame.of(setup)
    turned, translation = frame.pose(rotation, position)
    centre, vector = frame.pixels(theta[:, 2:4]), rotation_vectors(turned)
    focal, k = np.exp(theta[:, :2]), geometry.coefficients(theta)
    return np.concatenate([focal, centre, vector, translation, k], axis=1)


def save_opencv(found: FamilyComparison, path: str | Path, *, force: bool = False) -> None:
    """Write a fitted pinhole for ``cv2.FileStorage``, YAML.

    Parameters
    ----------
    found : FamilyComparison
        As of `bayescal.fit_family`.
    path : str or Path
        Such as ``"camera.yml"``.
    force : bool, optional
        Replace what is there.

    Raises
    ------
    InputError
        As `opencv_camera`.
    OutputError
        Where the file can't be written, or exists.
    """
    write_whole(Path(path), str(opencv_camera(found)).encode(), force=force)
