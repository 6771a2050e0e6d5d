"""How often each order wins over resamples, and whether orders beyond would."""

from __future__ import annotations

from matplotlib.figure import Figure

from bayescal.comparison.alone import stability_of
from bayescal.errors import InputError
from bayescal.report.figures.style import BLUE, ORANGE, PALE, WIDTH, legend_of, one_panel
from bayescal.report.figures.subject import Subject
from bayescal.rounding import percent


def draw(subject: Subject) -> Figure:
    """Draw bars per order: share of resamples won, and probability with orders beyond."""
    axis, series = subject.axis, _series(subject)
    orders = list([*series.values()][-1])
    figure, panel = one_panel(WIDTH, 3.0)
    width = 0.8 / len(series)
    for place, ((label, shares), colour) in enumerate(
        zip(series.items(), (BLUE, ORANGE, PALE)[-len(series) :], strict=True)
    ):
        shift = (place - (len(series) - 1) / 2) * width
        known = [k for k in orders if k in shares]
        heights = [100 * shares[k] for k in known]
        panel.bar([k + shift for k in known], heights, width=width, color=colour, label=label)
    compared = [r.order for r in axis.orders]
    beyond = [k for k in orders if k > compared[-1]]
    panel.set_xticks(orders, [f"{k}\nbeyond" if k in beyond else str(k) for k in orders])
    panel.set_ylim(0, 104)
    panel.set_xlabel(f"order of {axis.data.axis}({axis.data.regressor})")
    panel.set_ylabel("share, probability [%]")
    panel.set_title(f"{axis.data.axis}: which order wins with other points", loc="left")
    panel.tick_params(axis="x", length=0)
    legend_of(panel, "lower center", 3)
    return figure


def _series(subject: Subject) -> dict[str, dict[int, float]]:
    """Shares by order, under what they are of; the last has every order, compared and beyond."""
    resampled, beyond = stability_of(subject.comparison, subject.axis.data.axis)
    if beyond is None:
        raise InputError(
            "bootstrap needs a closed form with an evidence; robust noise has orders beyond with "
            "--defend, a flat prior none"
        )
    series = {f"wins with {b.unit}s resampled": b.share for b in resampled}
    return {**series, "probability with orders beyond": beyond.probability}


def alt_text(subject: Subject) -> str:
    """Say every share."""
    parts = []
    for label, shares in _series(subject).items():
        values = ", ".join(f"order {k} {percent(share)}" for k, share in shares.items())
        parts.append(f"{label[0].upper()}{label[1:]}: {values}.")
    return f"Bars of {subject.axis.data.axis} by order. {' '.join(parts)}"
