"""How far each order's prediction of left-out points is behind the best order's."""

from __future__ import annotations

from matplotlib.figure import Figure

from bayescal.comparison.alone import prediction_of
from bayescal.comparison.defence.results import Prediction
from bayescal.errors import InputError
from bayescal.report.figures.style import BLUE, GREY, VERMILLION, WIDTH, legend_of, one_panel
from bayescal.report.figures.subject import Subject


def draw(subject: Subject) -> Figure:
    """Draw a row per order: difference of elpd with its paired standard error."""
    axis, found = subject.axis, _prediction(subject)
    groups = _by_group(found)
    figure, panel = one_panel(WIDTH, 1.3 + 0.3 * len(found))
    panel.axvline(0, color=GREY, linewidth=0.8)
    rows = dict(zip(found, range(len(found)), strict=True))
    panel.errorbar(
        [p.difference for p in found.values()],
        list(rows.values()),
        xerr=[p.difference_se for p in found.values()],
        fmt="o",
        color=BLUE,
        markersize=5,
        elinewidth=1.3,
        capsize=2.5,
        label="a point left out, ± paired standard error",
    )
    if groups:
        panel.plot(
            list(groups.values()),
            [rows[k] + 0.25 for k in groups],
            "D",
            color=VERMILLION,
            markersize=4.5,
            fillstyle="none",
            label=f"a group left out ({subject.group_words})",
        )
    panel.set_yticks(list(rows.values()), [f"order {k}" for k in found])
    panel.set_ylim(len(found) - 0.5, -0.5)
    panel.set_xlabel("elpd less the best order's [nat]")
    title = f"{axis.data.axis}({axis.data.regressor}): prediction of points left out"
    panel.set_title(title, loc="left")
    panel.tick_params(axis="y", length=0)
    side = panel.secondary_yaxis("right")
    side.set_yticks(list(rows.values()), [_numbers(p) for p in found.values()])
    side.tick_params(length=0)
    side.spines["right"].set_visible(False)
    legend_of(panel, "lower center", 2)
    return figure


def _prediction(subject: Subject) -> dict[int, Prediction]:
    found = prediction_of(subject.comparison, subject.axis.data.axis)
    if not found:
        raise InputError(
            "loo is unavailable: some order is undetermined without a point, or these are a sample "
            "of many points, which --defend reads again"
        )
    return found


def _by_group(found: dict[int, Prediction]) -> dict[int, float]:
    """Difference of group elpd to the best; empty where there are no groups."""
    known = {k: p.group_elpd for k, p in found.items() if p.group_elpd is not None}
    best = max(known.values(), default=0.0)
    return {k: value - best for k, value in known.items()}


def _numbers(found: Prediction) -> str:
    if found.difference == 0:
        return "best"
    return f"{_signed(found.difference)} ± {found.difference_se:.1f}"


def _signed(value: float) -> str:
    """Write with a true minus sign, and no minus zero."""
    return f"{round(value, 1) + 0.0:.1f}".replace("-", "\N{MINUS SIGN}")


def alt_text(subject: Subject) -> str:
    """Say every difference with its error."""
    found = _prediction(subject)
    parts = ", ".join(f"order {k} {_numbers(p)}" for k, p in found.items())
    groups = ", ".join(f"order {k} {_signed(value)}" for k, value in _by_group(found).items())
    grouped = f" With {subject.group_words} left out: {groups}." if groups else ""
    return (
        f"Leave-one-out elpd of {subject.axis.data.axis} less the best order's, ± paired standard "
        f"error, nat: {parts}.{grouped}"
    )
