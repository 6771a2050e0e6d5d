"""Where the two most probable lenses predict otherwise."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.lenses.prediction import (
    covered,
    difference,
    image_grid,
    largest,
    observed_sample,
)
from bayescal.comparison.lenses.results import LensComparison
from bayescal.errors import InputError
from bayescal.report.figures.lenses.image import COLUMNS, ROWS, draw_contours, image_panel
from bayescal.report.figures.style import settle


def draw(found: LensComparison) -> Figure:
    """Draw contours of the distance of the predictions, the points beneath."""
    grid, apart = differences(found)
    first, second = found.lenses[:2]
    figure, panel = image_panel(found)
    draw_contours(panel, found, grid, np.hypot(*apart.T))
    panel.set_title(f"{second.name} against {first.name}: distance of predictions", loc="left")
    settle(figure)
    return figure


def differences(found: LensComparison) -> tuple[Array, Array]:
    """Give pixels of a grid and the second lens's prediction less the first's, ``(n, 2)`` each."""
    if len(found.lenses) < 2:
        raise InputError("difference needs two lenses; only one was compared")
    data = found.setting.data
    grid, sample = image_grid(data.size, COLUMNS, ROWS), observed_sample(data)
    first, second = found.lenses[:2]
    apart = difference(first.view, second.view, grid, sample, None)
    if largest(apart) is None:
        raise InputError(f"{second.name} can't be compared with {first.name} over the image")
    return grid, apart


def alt_text(found: LensComparison) -> str:
    """Say how far apart they are where the points are, and over the image."""
    grid, apart = differences(found)
    first, second = found.lenses[:2]
    inside = largest(apart[covered(grid, found.setting.data)])
    words = "" if inside is None else f"up to {inside:.2g} px where there are points, "
    return (
        f"Contours of the distance of predictions of {second.name} and {first.name} over the "
        f"image: {words}{largest(apart):.2g} px over the image."
    )
