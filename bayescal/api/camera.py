"""The calibrated camera from Python: of a result, a run or a file, and what it answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bayescal.cameras.undistortion import Field
from bayescal.errors import InputError
from bayescal.prediction.calibrated import CalibratedCamera
from bayescal.prediction.changed import Change
from bayescal.prediction.changed import changed as change_of
from bayescal.prediction.columns import (
    location_columns,
    pair_columns,
    prediction_columns,
    undistorted_columns,
)
from bayescal.prediction.locate import locate as locate_pixels
from bayescal.prediction.locate import surface_of
from bayescal.prediction.maps import ImageMaps
from bayescal.prediction.maps import image_maps as maps_of
from bayescal.prediction.pairs import distances as distances_between
from bayescal.prediction.predict import checked
from bayescal.prediction.predict import predict as predict_pixels
from bayescal.prediction.target import TargetPose
from bayescal.prediction.target import locate_target as pose_of
from bayescal.prediction.undistorting import Undistortion
from bayescal.prediction.undistorting import undistortion as undistortion_of


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
        from bayescal.prediction.sources import camera_of

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
        Means and deviations of the mapping and of a new measurement, px. For a data frame its
        rows with the columns that ``bayescal predict`` writes.

    Raises
    ------
    InputError
        Where the points have another shape, or a number is not finite.
    """
    fitted = camera(source)
    found = predict_pixels(fitted, _numbers(world, ("x", "y", "z"), "world"), average=average)
    return _like(world, found, prediction_columns)


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
        Of the draws of noise and depth.

    Returns
    -------
    Location or DataFrame
        Means and deviations by Monte Carlo and by linear propagation, world units, or unit vectors
        without depth and plane. For a data frame its rows with the columns that ``bayescal
        locate`` writes.

    Raises
    ------
    InputError
        Where the pixels have another shape, a number is not finite, or a surface is none.
    """
    surface = surface_of(depth, depth_sd, plane)
    own = _numbers(pixels, ("r", "c"), "pixels")
    found = locate_pixels(camera(source), own, surface=surface, average=average, seed=seed)
    return _like(pixels, found, location_columns)


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
    ends = checked(_numbers(pairs, ("r1", "c1", "r2", "c2"), "pairs"), 4, "pairs")
    found = distances_between(
        camera(source), ends[:, :2], ends[:, 2:], surface, average=average, seed=seed
    )
    return _like(pairs, found, pair_columns)


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
        Of the noise's draws.

    Returns
    -------
    TargetPose

    Raises
    ------
    InputError
        Where arrays have another shape or hold something else, the target has too few points, or
        no pose puts all of them where the camera can see them.
    """
    points = _numbers(target, ("x", "y", "z"), "target")
    if pixels is None:
        if points is target:
            raise InputError("pixels are missing: give r, c of each point, or a data frame of both")
        pixels = _numbers(target, ("r", "c"), "target")
    return pose_of(camera(source), points, pixels, average=average, sigma=sigma, seed=seed)


def image_maps(source: Any, *, columns: int = 33, rows: int = 25) -> ImageMaps:
    """Map over the image how sure the mapping is, and what other plausible models would move.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
    columns, rows : int, optional
        Of the grid over the image.

    Returns
    -------
    ImageMaps
        Deviations of the mapping, of a new measurement and averaged, differences of the models,
        px; `bayescal.plot` draws them (``"sd-map"``, ``"difference-map"``).
    """
    return maps_of(camera(source), columns=columns, rows=rows)


def changed(first: Any, second: Any, *, average: bool | None = None, seed: int = 0) -> Change:
    """Compare two calibrations of one camera, to learn whether it is still the same.

    Parameters
    ----------
    first, second : CalibratedCamera, or anything `camera` takes
    average : bool, optional
        As in `camera`, of both.
    seed : int, optional
        Of the pairing of the draws.

    Returns
    -------
    Change
        How far predictions lie apart over the image, px, and how often two calibrations of one
        camera would lie so far apart.

    Raises
    ------
    InputError
        Where they are of different cameras, or nothing was calibrated by both.
    """
    return change_of(camera(first), camera(second), average=average, seed=seed)


def undistortion(source: Any, *, field: Field = "same") -> Undistortion:
    """Choose a camera without distortion that sees what a calibrated one sees.

    Parameters
    ----------
    source : CalibratedCamera, or anything `camera` takes
        A lens, or polynomials: these give each pixel a direction x/z, y/z.
    field : {"same", "inside", "full"} or float
        The same focal length and principal point (of polynomials those straight ahead); as much
        as leaves no pixel black; as much as loses no pixel; or so many degrees from left to right.

    Returns
    -------
    Undistortion
        Its ``pixels``, ``distorted`` and ``image`` apply it; the table of ``cv2.remap`` is made
        once, with the first image.

    Raises
    ------
    InputError
        Where there is no such camera, or the image's size is unknown.
    """
    return undistortion_of(camera(source), field)


def undistort(source: Any, pixels: Any, *, field: Field = "same") -> Any:
    """Take the distortion out of pixels.

    Parameters
    ----------
    source, field
        As in `undistortion`.
    pixels : array_like or DataFrame
        r, c as recorded, ``(n, 2)``, px; a data frame has columns r, c.

    Returns
    -------
    Array or DataFrame
        Pixels of the ideal camera, ``(n, 2)``, px; nan where it sees no such direction. For a
        data frame its rows with the columns that ``bayescal undistort --pixels`` writes.

    Raises
    ------
    InputError
        Where there is no such camera, or the pixels have another shape.
    """
    own = checked(_numbers(pixels, ("r", "c"), "pixels"), 2, "pixels")
    found = undistortion(source, field=field).pixels(own)
    return _like(pixels, found, undistorted_columns)


def _numbers(given: Any, names: tuple[str, ...], what: str) -> Any:
    """Take the named columns of a data frame; anything else as it is."""
    if not hasattr(given, "columns"):
        return given
    missing = [name for name in names if name not in given.columns]
    if missing:
        needed = ", ".join(names)
        raise InputError(f"{what}: the data frame has no column {missing[0]!r}; it needs {needed}")
    return np.asarray(given[list(names)])


def _like(given: Any, found: Any, columns: Callable[[Any], dict[str, Any]]) -> Any:
    """Answer a data frame by one: its rows, and what was found."""
    return given.assign(**columns(found)) if hasattr(given, "columns") else found
