"""What pixels look at, and distances between them, as tables and files of rows."""

from __future__ import annotations

from typing import Any

import numpy as np

from bayescal.arrays import Array
from bayescal.points.partial import PartialTable
from bayescal.prediction.calibrated import CalibratedCamera
from bayescal.prediction.locate import SOURCES, Location, Surface
from bayescal.prediction.members import BoolArray
from bayescal.prediction.pairs import Distances
from bayescal.report.blocks import Blocks, Listing, Tabled
from bayescal.report.table import Cell, Column, Table
from bayescal.report.views.prediction import SHOWN, clipped, models_words
from bayescal.rounding import counted, rounded, significant

SCHEMA, PAIRS_SCHEMA = "bayescal-location-1", "bayescal-distances-1"
NO_SOLUTION = "nothing in the calibrated domain appears there"


def location_rows(table: PartialTable, found: Location) -> dict[str, Any]:
    """Columns of the file: pixels, then points or directions."""
    names = "xyz" if found.surface is not None else ("dx", "dy", "dz")
    columns: dict[str, Any] = {"label": list(table.labels)}
    columns |= {name: table.values[name] for name in "rc"}
    for form, array in (
        ("{}", found.values),
        ("sd_{}", found.sd),
        ("linear_sd_{}", found.linear_sd),
        ("lower_{}", found.lower),
        ("upper_{}", found.upper),
        *((f"{source}_sd_{{}}", found.parts[source]) for source in SOURCES),
    ):
        columns |= {form.format(name): array[:, i] for i, name in enumerate(names)}
    if found.surface is None:
        columns["angle_sd"] = found.angle
    columns["note"] = location_remarks(found)
    return columns


def location_remarks(found: Location) -> list[str]:
    """Say of each pixel why it has no answer, or what stands against it."""
    out = []
    for i, ok in enumerate(found.found):
        if ok:
            words = ["extrapolated"] * bool(found.extrapolated[i])
            words += ["linear propagation differs"] * bool(found.nonlinear[i])
            out.append(", ".join(words))
        elif found.count[i] > 1:
            out.append(f"{found.count[i]} points of the calibrated domain appear there")
        elif found.count[i] == 0:
            out.append(NO_SOLUTION)
        else:
            out.append("the ray does not meet the surface in front of the camera")
    return out


def location_view(camera: CalibratedCamera, table: PartialTable, found: Location) -> Blocks:
    """Show points or directions, and what they rest on."""
    flat = found.surface is not None
    names = "xyz" if flat else ("dx", "dy", "dz")
    columns = (
        Column("pixel"),
        *(Column(name) for name in names),
        *(Column(f"sd {name}") for name in names),
        *(() if flat else (Column("mrad"),)),
        Column(""),
    )
    short = {NO_SOLUTION: "no solution"}
    remarks, rows = [short.get(text, text) for text in location_remarks(found)], []
    for i in range(min(len(found), SHOWN)):
        label = Cell(clipped(table.labels[i]))
        if not found.found[i]:
            rows.append((label, *[Cell("")] * (len(columns) - 2), Cell(remarks[i])))
            continue
        sd = found.sd[i]
        angle = () if flat else (Cell(significant(1000 * found.angle[i])),)
        rows.append(
            (
                label,
                *(Cell(rounded(v, s)) for v, s in zip(found.values[i], sd, strict=True)),
                *(Cell(significant(s)) for s in sd),
                *angle,
                Cell(remarks[i]),
            )
        )
    what = surface_words(found.surface, posed=camera.posed)
    return (
        Listing((f"{counted(len(found), 'pixel')} {what}, {models_words(camera)}",), "about"),
        Tabled("locations", "Locations.", Table(columns, tuple(rows)), tuple(_lines(found))),
    )


def surface_words(surface: Surface | None, *, posed: bool) -> str:
    """Where points are taken to lie, in words."""
    frame = "" if posed else " in the camera's frame"
    if surface is None:
        return f"as directions{frame}"
    a, b, c = surface.normal
    sure = f" (sd {surface.sd:g}, the same error for all)" if surface.sd else ""
    if (a, b, c) == (0, 0, 1):
        return f"at z = {surface.offset:g}{sure}{frame}"
    return f"on the plane {a:g} x + {b:g} y + {c:g} z = {surface.offset:g}{sure}{frame}"


def _lines(found: Location) -> list[str]:
    lines = []
    if len(found) > SHOWN:
        lines.append(f"and {counted(len(found) - SHOWN, 'more pixel')} (--out FILE has all)")
    lines.append(
        "sd: by Monte Carlo over the posterior's draws (JCGM 101), with the pixel's noise."
    )
    usable = found.found
    if found.surface is None:
        lines.append("mrad: sd of the direction about each of two axes.")
    if NO_SOLUTION in location_remarks(found):
        lines.append(f"no solution: {NO_SOLUTION}.")
    if usable.any():
        lines.append(f"Of the variance: {_shares(found.parts, usable)}.")
        apart = int((found.nonlinear & usable).sum())
        verdict = (
            f"differs by more than the digits shown for {counted(apart, 'pixel')}"
            if apart
            else "agrees to the digits shown"
        )
        lines.append(f"Linear propagation (JCGM 100) {verdict}.")
    least = float(found.share[usable].min(initial=1.0))
    if least < 1:
        lines.append(
            f"As few as {100 * least:.0f} % of a pixel's draws have a solution, and count."
        )
    return lines


def _shares(parts: dict[str, Array], usable: BoolArray) -> str:
    """Share of each source in the variance, over all answers."""
    totals = {name: float((parts[name][usable] ** 2).sum()) for name in SOURCES}
    whole = sum(totals.values()) or 1.0
    return ", ".join(f"{name} {100 * t / whole:.0f} %" for name, t in totals.items() if t)


def pair_rows(table: PartialTable, found: Distances) -> dict[str, Any]:
    """Columns of the file of distances."""
    columns: dict[str, Any] = {"label": list(table.labels)}
    columns |= {name: table.values[name] for name in ("r1", "c1", "r2", "c2")}
    columns |= {"distance": found.values, "u": found.u, "k": found.k, "U": found.expanded}
    columns |= {"linear_u": found.linear_u}
    columns |= {f"u_{name}": found.parts[name] for name in SOURCES}
    columns["note"] = ["" if ok else "an end has no solution, or several" for ok in found.found]
    return columns


def pair_view(
    camera: CalibratedCamera, table: PartialTable, found: Distances, surface: Surface
) -> Blocks:
    """Show distances, with a statement for a certificate."""
    heads = ("pair", "distance", "u", "k", "U", *(f"u {name}" for name in SOURCES), "")
    rows = []
    for i in range(min(len(found), SHOWN)):
        label = Cell(clipped(table.labels[i]))
        if not found.found[i]:
            words = Cell("an end has no solution, or several")
            rows.append((label, *[Cell("")] * (len(heads) - 2), words))
            continue
        u = float(found.u[i])
        parts = (Cell(significant(float(found.parts[name][i]))) for name in SOURCES)
        cells = (
            Cell(rounded(float(found.values[i]), u)),
            Cell(significant(u)),
            Cell(f"{found.k[i]:.2f}"),
            Cell(significant(float(found.expanded[i]))),
        )
        rows.append((label, *cells, *parts, Cell("")))
    where = surface_words(surface, posed=camera.posed)
    shown = Table(tuple(Column(h) for h in heads), tuple(rows))
    return (
        Listing((f"{counted(len(found), 'distance')} {where}, {models_words(camera)}",), "about"),
        Tabled("distances", "Distances.", shown, tuple(_statement(found))),
    )


def _statement(found: Distances) -> list[str]:
    """Say what a certificate can of the first distance, and where propagation is not linear."""
    good = np.flatnonzero(found.found)
    lines = []
    if good.size:
        i = int(good[0])
        expanded = float(found.expanded[i])
        lines.append(
            f"For a certificate: {rounded(float(found.values[i]), expanded)} +- "
            f"{significant(expanded)} world units, expanded uncertainty U = k u, k = "
            f"{found.k[i]:.2f}, coverage probability {100 * found.probability:g} %, by Monte "
            "Carlo (JCGM 101:2008) from the calibration's posterior, pixel noise and depth."
        )
    if (np.abs(found.u - found.linear_u)[good] > 0.15 * found.u[good]).any():
        lines.append("Linear propagation differs by more than the digits shown for some pairs.")
    return lines
