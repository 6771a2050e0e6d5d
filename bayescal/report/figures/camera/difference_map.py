"""What the other plausible models predict otherwise, over the image."""

from __future__ import annotations

from matplotlib.figure import Figure

from bayescal.errors import InputError
from bayescal.prediction.maps import ImageMaps
from bayescal.report.figures.camera.panels import draw_map, draw_shifts, finished, image_panels
from bayescal.report.typography import typeset
from bayescal.rounding import percent

MOST = 4  # models
EVERY = 4  # places of the grid between arrows


def draw(maps: ImageMaps) -> Figure:
    """Draw a panel for each other model, the most probable first."""
    _check(maps)
    shown = maps.differences[:MOST]
    figure, panels = image_panels(maps, len(shown))
    for panel, one in zip(panels, shown, strict=True):
        draw_map(panel, maps, one.shift, typeset(f"to {one.other}, {percent(one.probability)}"))
        draw_shifts(panel, maps, one.shift, EVERY)
    return finished(figure)


def alt_text(maps: ImageMaps) -> str:
    """Say what each model moves."""
    _check(maps)
    return " ".join(maps.sentences[:MOST])


def _check(maps: ImageMaps) -> None:
    if not maps.differences:
        raise InputError("difference-map needs another plausible model: there is one alone")
