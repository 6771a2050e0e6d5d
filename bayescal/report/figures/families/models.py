"""Evidence of every model of r and c: a cell for each order, family and camera position."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from bayescal.comparison.families.result import JointModel
from bayescal.comparison.families.results import FamilyComparison
from bayescal.comparison.key import FREE, PINHOLE, STATED
from bayescal.report.figures.comparison.joint import LINES, SHADES
from bayescal.report.figures.style import VERMILLION, WIDTH, ink_on, several_panels
from bayescal.rounding import percent

RANGE = 20.0  # nat below the highest at which cells are white
ROW, ROOM = 0.3, 0.62  # inches: of a row of cells, of what stands around a panel
BAR = 0.75  # inches: of the colour bar below
ROOMY = 0.4  # inches: the narrowest cell with its number in it
NAMED = 4


def draw(found: FamilyComparison) -> Figure:
    """Draw a panel per family and position, all on one scale; the best model is framed."""
    families = list(dict.fromkeys(found.request.families))
    positions = [p for p in (STATED, FREE) if any(m.key.position == p for m in found.models)]
    grids = {f: _grid([m for m in found.models if m.key.family == f]) for f in families}
    heights = [ROW * len(rows) + ROOM for rows, _ in grids.values()]
    across = max(len(columns) for _, columns in grids.values())
    figure = several_panels(WIDTH, sum(heights) + BAR)
    panels = figure.subplots(len(families), len(positions), squeeze=False, height_ratios=heights)
    write = 0.84 * WIDTH / len(positions) / across > ROOMY
    mesh = None
    for line, family in zip(panels, families, strict=True):
        for panel, position in zip(line, positions, strict=True):
            of = [m for m in found.models if m.key.family == family]
            kind = [m for m in of if m.key.position == position]
            if not kind:
                panel.set_axis_off()
                continue
            mesh = _panel(panel, found, kind, grids[family], write=write)
            panel.set_xlim(-0.5, across - 0.5)
            panel.xaxis.label.set_x(len(grids[family][1]) / across / 2)  # below its own cells
            panel.set_title(f"{family}, position {position}", loc="left")
    assert mesh is not None, "some model was compared"
    # Below the panels, where its label fits however few rows there are.
    bar = figure.colorbar(mesh, ax=panels, extend="min", location="bottom", shrink=0.5, aspect=40)
    bar.set_ticks([0, -5, -10, -15, -20])
    bar.set_label("ln evidence less the highest [nat]")
    return figure


def _grid(models: list[JointModel]) -> tuple[list[int], list[int]]:
    """Orders down (one row where a model has a single order) and across."""
    orders = [m.key.orders for m in models]
    rows = sorted({o[0] for o in orders}) if len(orders[0]) > 1 else [0]
    return rows, sorted({o[-1] for o in orders})


def _panel(
    panel: Axes,
    found: FamilyComparison,
    models: list[JointModel],
    grid: tuple[list[int], list[int]],
    *,
    write: bool,
) -> QuadMesh:
    """Draw the cells of one family at one kind of position."""
    rows, columns = grid
    top = max(m.log_evidence for m in found.models)
    pairs = len(models[0].key.orders) > 1
    table = np.full((len(rows), len(columns)), np.nan)
    for model in models:
        i = rows.index(model.key.orders[0]) if pairs else 0
        j = columns.index(model.key.orders[-1])
        table[i, j] = value = model.log_evidence - top
        if write:
            panel.text(
                j,
                i,
                _number(value) + ("" if model.sound else "!"),
                ha="center",
                va="center",
                fontsize=8.5,
                color=ink_on(SHADES(1 + value / RANGE)),
                weight="bold" if model.key in found.verdict.plausible else "normal",
            )
        if model is found.best:
            frame = Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, ec=VERMILLION, lw=2, zorder=3)
            panel.add_patch(frame).set_clip_on(False)
    edges = [np.arange(size + 1) - 0.5 for size in (len(columns), len(rows))]
    mesh = panel.pcolormesh(
        *edges, table, cmap=SHADES, vmin=-RANGE, vmax=0, edgecolors=LINES, linewidth=0.5
    )
    panel.set_ylim(len(rows) - 0.5, -0.5)  # as a table reads
    panel.set_xticks(range(len(columns)), [str(k) for k in columns])
    panel.set_yticks(range(len(rows)) if pairs else [], [str(k) for k in rows] if pairs else [])
    if pairs:
        panel.set_ylabel("order of r")
    panel.set_xlabel("order of c" if pairs else _order_words(models[0]))
    panel.tick_params(length=0)
    for spine in panel.spines.values():
        spine.set_visible(False)
    return mesh


def _order_words(model: JointModel) -> str:
    return "radial coefficients" if model.key.family == PINHOLE else "total degree"


def _number(value: float) -> str:
    if value > -0.0005:
        return "0"
    digits = 3 if value > -0.0095 else 2 if value > -0.095 else 1 if value > -99.95 else 0
    text = f"{value:.{digits}f}"
    return text.replace("-", "\N{MINUS SIGN}")


def alt_text(found: FamilyComparison) -> str:
    """Say the most probable models, and the best of every family and position."""
    top = max(m.log_evidence for m in found.models)
    first = ", ".join(
        f"{m.key} ({percent(chance)})"
        for m, chance in list(zip(found.models, found.probabilities, strict=True))[:NAMED]
    )
    kinds: dict[tuple[str, str], JointModel] = {}
    for m in found.models:
        kind = m.key.family, m.key.position
        if kind not in kinds or m.log_evidence > kinds[kind].log_evidence:
            kinds[kind] = m
    bests = ", ".join(f"{m.key} {m.log_evidence - top:.1f}" for m in kinds.values())
    return (
        f"Table of the log evidence of {len(found.models)} models less the highest, by family, "
        f"order and camera position. Most probable: {first}. Best of each family and position, "
        f"nat: {bests}."
    )
