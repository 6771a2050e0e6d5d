"""What pixels look at, and distances between them, as tables."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array
from bayescal.points.tables.partial import PartialTable
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import KEPT, BoolArray
from bayescal.prediction.columns import (
    NEAR_ZERO,
    NO_MEETING,
    NO_SOLUTION,
    location_remarks,
    pair_remarks,
)
from bayescal.prediction.given import Surface
from bayescal.prediction.locate import APART, Location
from bayescal.prediction.measuring import FEW, SOURCES
from bayescal.prediction.pairs import Distances
from bayescal.report.blocks import Blocks, Listing, Tabled
from bayescal.report.table import Cell, answers_table
from bayescal.report.views.prediction import SHOWN, models_words, names_of
from bayescal.rounding import counted, rounded, significant

SHORT = {NO_SOLUTION: "no solution", NO_MEETING: "no meeting"}
EXACT = 1e-12  # relative


def location_view(camera: CalibratedCamera, table: PartialTable, found: Location) -> Blocks:
    """Show points or directions, and what they rest on."""
    flat = found.surface is not None
    names = "xyz" if flat else ("dx", "dy", "dz")
    heads = ["pixel", *names, *(f"sd {name}" for name in names), *(() if flat else ["mrad"]), ""]

    def cells(i: int) -> list[Cell] | None:
        if not found.found[i]:
            return None
        # What is known exactly, as a stated z is, has the rounding of its sum alone.
        sd = np.where(found.sd[i] > EXACT * np.abs(found.values[i]), found.sd[i], 0.0)
        return [
            *(Cell(rounded(v, s)) for v, s in zip(found.values[i], sd, strict=True)),
            *(Cell(significant(s)) for s in sd),
            *(() if flat else [Cell(significant(1000 * found.angle[i]))]),
        ]

    remarks = [_short(text) for text in location_remarks(found)[:SHOWN]]
    shown = answers_table(heads, names_of(table), cells, remarks)
    what = surface_words(found.surface, posed=camera.posed)
    return (
        Listing((f"{counted(len(found), 'pixel')} {what}, {models_words(camera)}",), "about"),
        Tabled("locations", "Locations.", shown, tuple(_lines(found))),
    )


def _short(remark: str) -> str:
    """Shorten a remark to fit a table."""
    for words, short in SHORT.items():
        remark = remark.replace(words, short)
    return remark.replace(" the image", "")


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
    units = "x, y, z and their sd: world units; sd" if found.surface is not None else "sd"
    lines.append(
        f"{units}: by Monte Carlo over the posterior's draws (JCGM 101), with the pixel's noise."
    )
    usable = found.found
    if found.surface is None:
        lines.append("mrad: sd of the direction about each of two axes.")
    lines += [
        f"{short}: {words}."
        for words, short in SHORT.items()
        if any(words in text for text in location_remarks(found))
    ]
    if found.outside.all():
        lines.append("All pixels lie outside the image: are they of another camera?")
    if usable.any():
        lines.append(f"Of the variance: {_shares(found.parts, usable)}.")
        apart = int((found.nonlinear & usable).sum())
        lines.append(agreement("Linear propagation (JCGM 100)", apart, "pixel"))
    least = float(found.share[usable].min(initial=1.0))
    if least < 1:
        few = f"; below {100 * FEW:g}% no interval is told" if least < FEW else ""
        lines.append(
            f"As few as {100 * least:.3g}% of a pixel's draws have a solution: mean and sd are of "
            f"these{few}."
        )
    return lines


def agreement(what: str, apart: int, noun: str) -> str:
    """Say whether linear propagation agrees, and within what: no more than the draws can tell."""
    within = f"{100 * APART:.0f}% of the sd"
    if apart:
        return f"{what} differs by more than {within} for {counted(apart, noun)}."
    return f"{what} agrees within {within}, which {KEPT} draws of each model can tell."


def _shares(parts: dict[str, Array], usable: BoolArray) -> str:
    """Share of each source in the variance, over all answers."""
    totals = {name: float((parts[name][usable] ** 2).sum()) for name in SOURCES}
    whole = sum(totals.values()) or 1.0
    return ", ".join(f"{name} {100 * t / whole:.0f}%" for name, t in totals.items() if t)


def pair_view(
    camera: CalibratedCamera, table: PartialTable, found: Distances, surface: Surface
) -> Blocks:
    """Show distances, with a statement for a certificate."""
    heads = ("pair", "distance", "u", "k", "U", *(f"u {name}" for name in SOURCES), "")

    def cells(i: int) -> list[Cell] | None:
        if not found.found[i]:
            return None
        u = float(found.u[i])
        return [
            Cell(rounded(float(found.values[i]), u)),
            Cell(significant(u)),
            Cell(f"{found.k[i]:.1f}" if found.certain[i] else ""),
            Cell(significant(float(found.expanded[i])) if found.certain[i] else ""),
            *(Cell(significant(float(found.parts[name][i]))) for name in SOURCES),
        ]

    where = surface_words(surface, posed=camera.posed)
    shown = answers_table(heads, names_of(table), cells, pair_remarks(found)[:SHOWN])
    return (
        Listing((f"{counted(len(found), 'distance')} {where}, {models_words(camera)}",), "about"),
        Tabled("distances", "Distances.", shown, tuple(_statement(found))),
    )


def _statement(found: Distances) -> list[str]:
    """Say what a certificate can of the first distance, and where propagation is not linear."""
    good, certain = np.flatnonzero(found.found), np.flatnonzero(found.certain)
    lines = []
    told = np.flatnonzero(found.certain & found.apart)
    if told.size:
        i = int(told[0])
        expanded, error = float(found.expanded[i]), found.expanded_error[i]
        lines.append(
            f"For a certificate: {rounded(float(found.values[i]), expanded)} ± "
            f"{significant(expanded)} world units, expanded uncertainty U = k u, k = "
            f"{found.k[i]:.1f}, coverage probability {100 * found.probability:g}%, by Monte "
            "Carlo (JCGM 101:2008) from the calibration's posterior, pixel noise and depth. The "
            f"number of draws leaves U a standard error of {significant(100 * error / expanded)}%."
        )
    if good.size > certain.size:
        lines.append(
            f"% of draws answer: of fewer than {100 * FEW:g}% of the draws no interval can hold "
            f"{100 * found.probability:g}%: no U. u is of the draws that have a distance."
        )
    if NEAR_ZERO in pair_remarks(found):
        lines.append(f"{NEAR_ZERO}: noise alone sets two measurements of one point so far apart.")
    if good.size:
        apart = np.abs(found.u - found.linear_u)[good] > APART * found.u[good]
        lines.append(agreement("Linear propagation (JCGM 100)", int(apart.sum()), "pair"))
    return lines
