"""What the other plausible models predict otherwise, over the image."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.errors import InputError
from bayescal.prediction.maps import ImageMaps
from bayescal.report.figures.camera.panels import draw_map, image_panels
from bayescal.report.figures.style import BLUE, settle

MOST = 4  # models
EVERY = 4  # places of the grid between arrows
LONG = 0.09  # of the image's width: the longest arrow inside


def draw(maps: ImageMaps) -> Figure:
    """Draw a panel for each other model, the most probable first."""
    _check(maps)
    shown = maps.differences[:MOST]
    figure, panels = image_panels(maps, len(shown), flipped=maps.flipped)
    some = np.zeros(maps.shape, dtype=bool)
    some[EVERY // 2 :: EVERY, EVERY // 2 :: EVERY] = True
    some = some.ravel() & maps.places.inside
    width = float(np.ptp(maps.places.pixels[:, 0]))
    for panel, one in zip(panels, shown, strict=True):
        title = f"to {one.other}, {100 * one.probability:.0f} %"
        draw_map(panel, maps, one.size, title)
        longest = float(np.nanmax(one.size[some], initial=0.0))
        if longest > 0:
            panel.quiver(
                *maps.places.pixels[some].T, *one.shift[some].T, angles="xy", scale_units="xy",
                scale=longest / (LONG * width), width=0.004, color=BLUE,
            )  # fmt: skip
    settle(figure)
    return figure


def alt_text(maps: ImageMaps) -> str:
    """Say what each model moves."""
    _check(maps)
    return " ".join(maps.sentences[:MOST])


def _check(maps: ImageMaps) -> None:
    if not maps.differences:
        raise InputError("difference-map needs another plausible model: there is one alone")
