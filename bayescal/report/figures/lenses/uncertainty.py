"""How sure the projection is over the image."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.comparison.lenses.places import between
from bayescal.comparison.lenses.prediction import deviation, image_grid, observed_sample, response
from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.lenses.image import COLUMNS, ROWS, draw_contours, image_panel
from bayescal.report.figures.style import settle


def draw(found: LensComparison) -> Figure:
    """Draw contours of the projection's deviation over the image, the points beneath."""
    figure, panel = image_panel(found)
    draw_contours(panel, found, *uncertainty(found))
    panel.set_title(f"{found.best.name}: standard deviation of the projection", loc="left")
    settle(figure)
    return figure


def uncertainty(found: LensComparison) -> tuple[Array, Array]:
    """Give pixels of a grid, ``(n, 2)``, and the deviation of the projection there, ``(n,)``."""
    data, view = found.setting.data, found.best.view
    grid, sample = image_grid(data.size, COLUMNS, ROWS), observed_sample(data)
    own = deviation(response(view, grid, sample, None), found.drawn.covariance)
    return grid, np.hypot(own, between(view, found.lenses, grid, sample, None))


def alt_text(found: LensComparison) -> str:
    """Say how large it is at the least and at the worst."""
    _, sd = uncertainty(found)
    known = sd[np.isfinite(sd)]
    return (
        "Contours of the standard deviation of the projection over the image, px: from "
        f"{known.min():.2g} to {known.max():.2g}."
    )
