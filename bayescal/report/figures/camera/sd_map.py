"""How sure the mapping is over the image: of the chosen model, of a measurement, of all models."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.prediction.maps import ImageMaps
from bayescal.report.figures.camera.panels import draw_map, finished, image_panels
from bayescal.rounding import significant


def draw(maps: ImageMaps) -> Figure:
    """Draw a panel for each standard deviation."""
    wanted = [
        (maps.epistemic, f"sd of the mapping, {maps.chosen}"),
        (maps.predictive, "sd of a new measurement"),
    ]
    if maps.differences:
        wanted.append((maps.averaged, "sd of the mapping, models averaged"))
    figure, panels = image_panels(maps, len(wanted))
    for panel, (values, title) in zip(panels, wanted, strict=True):
        draw_map(panel, maps, values, title)
    return finished(figure)


def alt_text(maps: ImageMaps) -> str:
    """Say how large the deviations are, among the calibration points and beyond."""
    parts = []
    for words, where in (("among the calibration points", maps.places.inside),
                         ("beyond them", maps.extrapolated)):  # fmt: skip
        known = maps.epistemic[where & np.isfinite(maps.epistemic)]
        if known.size:
            ends = " to ".join(significant(float(v)) for v in (known.min(), known.max()))
            parts.append(f"{words} {ends} px")
    return (
        f"Contours over the image of the standard deviation of the mapping by {maps.chosen}: "
        f"{'; '.join(parts)}."
    )
