"""What is wrong with the target: its bow, and its points that are off."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from bayescal.arrays import Array
from bayescal.calibration.fitting.stacking import bowl
from bayescal.comparison.lenses.results import LensComparison
from bayescal.errors import InputError
from bayescal.report.figures.comparison.image import arrow_scale, key_length
from bayescal.report.figures.style import BLUE, COLOURS, GREY, WIDTH, one_panel, settle

GRID = 41


def draw(found: LensComparison) -> Figure:
    """Draw the height of the bow as colour and the offsets within the plane as arrows."""
    target, offsets = parts(found)
    across, tall = np.ptp(target[:, 0]), np.ptp(target[:, 1])
    height = float(np.clip(0.85 * WIDTH * tall / max(across, 1e-300), 2.2, 7.0)) + 0.8
    figure, panel = one_panel(WIDTH, height)
    if found.setting.bow:
        shown = panel.pcolormesh(*surface(found), cmap=COLOURS, rasterized=True, alpha=0.55)
        figure.colorbar(shown, ax=panel, label="height of the bow [target's unit]", shrink=0.85)
    panel.plot(*target[:, :2].T, ".", color=GREY, markersize=4)
    lengths = np.hypot(*offsets[:, :2].T)
    if lengths.any():
        scale = arrow_scale(lengths) / across
        quiver = panel.quiver(
            *target[:, :2].T, *offsets[:, :2].T, angles="xy", scale_units="xy", scale=scale,
            width=0.003, color=BLUE,
        )  # fmt: skip
        key = key_length(lengths)
        panel.quiverkey(quiver, 0.9, 1.04, key, f"{key:g}", labelpos="W", color=GREY)
    panel.use_sticky_edges = False
    panel.margins(0.12)
    panel.invert_yaxis()
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_xlabel("x [target's unit, from its middle]")
    panel.set_ylabel("y [target's unit]")
    panel.set_title(
        "points off, as arrows (target's unit)" if lengths.any() else "no points off", loc="left"
    )
    settle(figure)
    return figure


def parts(found: LensComparison) -> tuple[Array, Array]:
    """Give points of the target and how far each is off, ``(n_target, 3)``, the target's unit.

    What poses absorb, a shift, turn or scale of all points, is taken out.
    """
    setting = found.setting
    if not (setting.bow or setting.grid.offsets):
        raise InputError("bow needs a target that may bow or be off; here it is taken as exact")
    data = setting.data
    x, y = data.target[:, :2].T
    one, none = np.ones_like(x), np.zeros_like(x)
    # Shift, turn and scale within the plane: all views' poses absorb them.
    rigid = np.stack([[one, none, -y, x], [none, one, x, y]]).transpose(0, 2, 1).reshape(-1, 4)
    offsets = found.problem.offsets.copy()
    flat = offsets[:, :2].T.ravel()
    left = flat - rigid @ np.linalg.lstsq(rigid, flat)[0]
    offsets[:, :2] = left.reshape(2, -1).T
    return data.target * data.diagonal, offsets * data.diagonal


def surface(found: LensComparison) -> tuple[Array, Array, Array]:
    """Height of the bow on a grid over the target, its unit: x, y, z, ``(GRID, GRID)`` each."""
    data = found.setting.data
    (low, high), bow = (data.target.min(axis=0), data.target.max(axis=0)), found.problem.bow
    x, y = np.meshgrid(*(np.linspace(low[i], high[i], GRID) for i in (0, 1)))
    z = bowl(data, np.stack([x, y], axis=-1)) @ bow
    return x * data.diagonal, y * data.diagonal, np.asarray(z) * data.diagonal


def alt_text(found: LensComparison) -> str:
    """Say how large bow and offsets are."""
    _, offsets = parts(found)
    words = []
    if found.setting.bow:
        z = surface(found)[2]
        words.append(f"its bow spans {np.ptp(z):.2g}")
    if offsets.any():
        size = np.sqrt((offsets[:, :2] ** 2).sum(axis=1).mean())
        words.append(f"its points are off within it by {size:.2g} in the root mean square")
    return f"The target, in its own unit: {' and '.join(words) or 'nothing is off'}."
