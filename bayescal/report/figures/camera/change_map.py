"""How far two calibrations of a camera predict points apart, over the image."""

from __future__ import annotations

from matplotlib.figure import Figure

from bayescal.prediction.changed import Change
from bayescal.report.figures.camera.panels import draw_map, draw_shifts, finished, image_panels


def draw(change: Change) -> Figure:
    """Draw the change, and its standard deviation beside it."""
    figure, (moved, sd) = image_panels(change, 2)
    draw_map(moved, change, change.shift, "change")
    draw_shifts(moved, change, change.shift, 3)
    draw_map(sd, change, change.sd, "its sd")
    return finished(figure)


def alt_text(change: Change) -> str:
    """Say what is found."""
    return change.verdict
