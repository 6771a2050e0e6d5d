"""What figures over the image of many views share."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bayescal.comparison.lenses.results import LensComparison
from bayescal.report.figures.style import WIDTH, one_panel


def image_panel(found: LensComparison) -> tuple[Figure, Axes]:
    """Lay out a figure that is the image."""
    width, height = found.setting.data.size
    figure, panel = one_panel(WIDTH, WIDTH * height / width * 0.95 + 0.4)
    frame(panel, found)
    panel.set_xlabel("r [px]")
    panel.set_ylabel("c [px]")
    return figure, panel


def frame(panel: Axes, found: LensComparison) -> None:
    """Make a panel the image, c downwards."""
    width, height = found.setting.data.size
    panel.set_xlim(-0.5, width - 0.5)
    panel.set_ylim(height - 0.5, -0.5)
    panel.set_aspect("equal")
