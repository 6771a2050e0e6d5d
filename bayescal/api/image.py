"""The image of a calibrated camera from Python: maps over it, changes of it, without distortion."""

from __future__ import annotations

from functools import partial
from typing import Any

from bayescal.api.camera import camera
from bayescal.api.rows import answered, numbers_of
from bayescal.cameras.undistortion import Field
from bayescal.prediction.changed import Change
from bayescal.prediction.changed import changed as change_of
from bayescal.prediction.columns import undistorted_columns
from bayescal.prediction.given import checked
from bayescal.prediction.maps import ImageMaps
from bayescal.prediction.maps import image_maps as maps_of
from bayescal.prediction.undistorting import Undistortion
from bayescal.prediction.undistorting import undistortion as undistortion_of


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
        Standard deviations of the mapping, of a new measurement and averaged, and differences of
        the models, px; `bayescal.plot` draws them (``"sd-map"``, ``"difference-map"``).
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
        Seed of the pairing of the draws.

    Returns
    -------
    Change
        How far predictions lie apart over the image, px, and the p-value: the probability of
        differences at least as large in a camera that did not change.

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
    own = checked(numbers_of(pixels, ("r", "c"), "pixels"), 2, "pixels")
    made = undistortion(source, field=field)
    columns = partial(undistorted_columns, outside=made.outside(own))
    return answered(pixels, made.pixels(own), columns)
