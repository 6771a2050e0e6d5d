"""The calibrated camera from Python: of a result, a run or a file, and what it answers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bayescal.api.rows import answered, numbers_of
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.columns import (
    location_columns,
    pair_columns,
    prediction_columns,
)
from bayescal.prediction.given import checked, surface_of
from bayescal.prediction.locate import locate as locate_pixels
from bayescal.prediction.pairs import distances as distances_between
from bayescal.prediction.predict import predict as predict_pixels
from bayescal.prediction.target import TargetPose
from bayescal.prediction.target import locate_target as pose_of


def camera(
    source: Any, *, average: bool | None = None, model: str | None = None
) -> CalibratedCamera:
    """Make the calibrated camera of a calibration: what is needed to measure, without its points.

    Parameters
    ----------
    source : a result of `compare`, `compare_families`, `calibrate`; CalibratedCamera, str or Path
        A result; or a run's folder, or a file that `keep_camera` wrote.
    average : bool, optional
        Whether it averages over all plausible models by their probabilities, or takes the most
        probable one; by default it averages where the verdict is undecided.
    model : str, optional
        Take this one of the plausible models alone.

    Returns
    -------
    CalibratedCamera

    Raises
    ------
    InputError
        Where the source holds no camera, or has no such model.
    """
    if isinstance(source, CalibratedCamera):
        found = source
    elif isinstance(source, str | Path):
        from bayescal.report.camera import camera_at

        found = camera_at(source)
    else:
        from bayescal.report.camera import camera_of

        found = camera_of(source)
    return (found if model is None else found.only(model)).average(average)


def predict(source: Any, world: Any, *, average: bool | None = None) -> Any:
    """Predict where points of the world appear, with their uncertainty.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
    world : array_like or DataFrame
        x, y, z, ``(n, 3)``, world units; a data frame has columns x, y, z.
    average : bool, optional
        As in `camera`.

    Returns
    -------
    Prediction or DataFrame
        Means and standard deviations of the mapping and of a new measurement, px. For a data
        frame its rows with the columns that ``bayescal predict`` writes.

    Raises
    ------
    InputError
        Where the points have another shape, or a number is not finite.
    """
    fitted = camera(source)
    found = predict_pixels(fitted, numbers_of(world, ("x", "y", "z"), "world"), average=average)
    return answered(world, found, prediction_columns)


def locate(
    source: Any,
    pixels: Any,
    *,
    depth: float | None = None,
    depth_sd: float = 0.0,
    plane: Sequence[float] | None = None,
    average: bool | None = None,
    seed: int = 0,
) -> Any:
    """Find what pixels look at: directions, or points at a known depth or on a known plane.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
    pixels : array_like or DataFrame
        Measured r, c as recorded, ``(n, 2)``, px; a data frame has columns r, c.
    depth : float, optional
        z of the points, world units.
    depth_sd : float, optional
        Its standard deviation: the same error for all pixels.
    plane : sequence of float, optional
        a, b, c, d: the points lie on a x + b y + c z = d.
    average : bool, optional
        As in `camera`.
    seed : int, optional
        Seed of the draws of noise and depth.

    Returns
    -------
    Location or DataFrame
        Means and standard deviations by Monte Carlo (JCGM 101:2008) and by linear propagation
        (JCGM 100:2008): points in world units or, without depth and plane, unit vectors. For a
        data frame its rows with the columns that ``bayescal locate`` writes.

    Raises
    ------
    InputError
        Where the pixels have another shape, a number is not finite, or a surface is none.
    """
    surface = surface_of(depth, depth_sd, plane)
    own = numbers_of(pixels, ("r", "c"), "pixels")
    found = locate_pixels(camera(source), own, surface=surface, average=average, seed=seed)
    return answered(pixels, found, location_columns)


def distances(
    source: Any,
    pairs: Any,
    *,
    depth: float | None = None,
    depth_sd: float = 0.0,
    plane: Sequence[float] | None = None,
    average: bool | None = None,
    seed: int = 0,
) -> Any:
    """Measure distances between pairs of pixels that look at a known depth or plane.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
    pairs : array_like or DataFrame
        r, c of both ends, ``(n, 4)``, px; a data frame has columns r1, c1, r2, c2.
    depth, depth_sd, plane
        As in `locate`; one of depth and plane is needed.
    average : bool, optional
        As in `camera`.
    seed : int, optional

    Returns
    -------
    Distances or DataFrame
        With expanded uncertainty and its budget, world units. For a data frame its rows with the
        columns that ``bayescal locate --pairs`` writes.

    Raises
    ------
    InputError
        Where there is no surface, or pixels have another shape.
    """
    surface = surface_of(depth, depth_sd, plane)
    ends = checked(numbers_of(pairs, ("r1", "c1", "r2", "c2"), "pairs"), 4, "pairs")
    found = distances_between(
        camera(source), ends[:, :2], ends[:, 2:], surface, average=average, seed=seed
    )
    return answered(pairs, found, pair_columns)


def locate_target(
    source: Any,
    target: Any,
    pixels: Any = None,
    *,
    average: bool | None = None,
    sigma: float | None = None,
    seed: int = 0,
) -> TargetPose:
    """Find the pose of a known target from one new picture of it, with its covariance.

    What solvePnP gives; the covariance holds the lens's uncertainty beside the pixels' noise.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
    target : array_like or DataFrame
        Points in the target's own frame, ``(n, 3)``, world units: at least four, not on a line. A
        data frame has columns x, y, z, r, c.
    pixels : array_like, optional
        Measured r, c of each as recorded, ``(n, 2)``, px; not beside a data frame.
    average : bool, optional
        As in `camera`.
    sigma : float, optional
        Sd of these pixels, px; by default that of the calibration's noise.
    seed : int, optional
        Seed of the noise's draws.

    Returns
    -------
    TargetPose

    Raises
    ------
    InputError
        Where arrays have another shape or hold something else, the target has too few points, or
        no pose puts all of them where the camera can see them.
    """
    points = numbers_of(target, ("x", "y", "z"), "target")
    if pixels is None:
        if points is target:
            raise InputError("pixels are missing: give r, c of each point, or a data frame of both")
        pixels = numbers_of(target, ("r", "c"), "target")
    return pose_of(camera(source), points, pixels, average=average, sigma=sigma, seed=seed)
