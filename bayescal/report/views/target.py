"""The pose of a known target, as a table."""

from __future__ import annotations

import numpy as np

from bayescal.points.tables.partial import PartialTable
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.columns import target_columns
from bayescal.prediction.locate import APART
from bayescal.prediction.target import SOURCES, UNLIKELY, TargetPose
from bayescal.report.blocks import Blocks, Listing, Tabled
from bayescal.report.table import Cell, plain_table
from bayescal.report.views.location import agreement
from bayescal.report.views.prediction import models_words
from bayescal.rounding import counted, percent, rounded, significant


def target_view(camera: CalibratedCamera, table: PartialTable, found: TargetPose) -> Blocks:
    """Show where the target stands, how sure that is and by what."""
    sources = [name for name in SOURCES if found.parts[name].any()]
    heads = ("", "value", "sd", "linear sd", *(f"sd by {name}" for name in sources))
    columns = target_columns(found)
    rows = []
    for i, name in enumerate(columns["quantity"]):
        angle = i >= 3
        unit = np.degrees(1.0) if angle else 1.0
        value, sd = unit * columns["value"][i], unit * columns["sd"][i]
        spreads = (unit * columns[key][i] for key in ("linear_sd", *(f"{n}_sd" for n in sources)))
        rows.append(
            (
                Cell(f"{name} [deg]" if angle else name),
                Cell(rounded(value, sd)),
                Cell(significant(sd)),
                *(Cell(significant(s)) for s in spreads),
            )
        )
    about = f"a target of {counted(len(table), 'point')}, {models_words(camera)}"
    shown = plain_table(heads, rows)
    caption = f"Pose of the target in the {found.frame}'s frame."
    return (
        Listing((about,), "about"),
        Tabled("target", caption, shown, (*_lines(found), *_sharing(camera))),
    )


def _sharing(camera: CalibratedCamera) -> list[str]:
    """Say what noise of neighbours is taken over from the calibration."""
    members, weights = camera.used
    levels = [m.noise.neighbours for m in members]
    drawn = np.array([0.0 if n is None else (n[:, 1] > 0).mean() for n in levels])
    chance, first = (
        float(np.array(weights) @ drawn),
        next((n for n in levels if n is not None), None),
    )
    if first is None:
        return []
    own, shared, length = np.median(first[first[:, 1] > 0], axis=0)
    return [
        f"Neighbours on the target shared noise in the calibration (probability {percent(chance)}; "
        f"{significant(shared)} px over {significant(length)} world units, beside "
        f"{significant(own)} px of each point's own). The same is assumed here: it makes the pose "
        "less sure than independent noise would."
    ]


def _lines(found: TargetPose) -> list[str]:
    lines = [
        "X = R p + t takes points p of the target to that frame: x, y, z are t, the turn is R's "
        "rotation vector; its sd is that of a turn about the frame's fixed axes.",
        "sd: by Monte Carlo over the posterior's draws and the pixels' noise (JCGM 101); its parts "
        "and linear sd by linear propagation. --json has the covariance, in ROS's order.",
    ]
    linear = np.sqrt(np.diag(found.linear_covariance))
    apart = int((np.abs(found.sd - linear) > APART * found.sd).sum())
    lines.append(agreement("Linear propagation", apart, "number"))
    text = f"Residuals: {significant(found.rms)} px root mean square"
    if found.p_value is None:
        lines.append(f"{text}.")
    elif found.p_value < UNLIKELY:
        lines.append(
            f"{text}: chi-squared {found.chi2:.1f} at {found.dof} dof is far more than the noise "
            "and the calibration's own uncertainty make (p < 0.001). Another target, a wrong "
            "pixel, or noise above the calibration's: state it by --sigma; until then the sds do "
            "not hold."
        )
    else:
        lines.append(f"{text}, chi-squared {found.chi2:.1f} at {found.dof} dof.")
    if found.mirrored is not None:
        lines.append(
            f"Its mirror image, z negated, has a chi-squared of {found.mirrored:.1f} alone: the "
            "target's frame and this world are of opposite hands (x right, y up, z forward is "
            "left-handed). Give the target's points with z negated."
        )
    if found.extrapolated.any():
        beyond = counted(int(found.extrapolated.sum()), "point")
        lines.append(f"{beyond} beyond where points were calibrated with (extrapolated).")
    if found.second is not None:
        turn = np.degrees(found.second.rotation)
        place, turned = (", ".join(f"{v:.4g}" for v in of) for of in (found.second.position, turn))
        lines.append(
            f"A second pose fits nearly as well (odds {found.odds:.1f} to 1): x, y, z {place}; "
            f"turn {turned} deg. A small or distant flat target does not tell them apart; the sds "
            "hold for either alone."
        )
    return lines
