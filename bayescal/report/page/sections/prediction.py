"""How well each order predicts what it has not seen."""

from __future__ import annotations

from bayescal.report.defence import prediction_lines, prediction_table
from bayescal.report.page.blocks import Section, Tabled
from bayescal.report.page.subject import PageSubject


def section(subject: PageSubject) -> Section | None:
    """Show leave-one-out differences with their errors."""
    parts = {}
    for axis in subject.axes:
        defence, name = axis.defence, axis.data.axis
        if defence is None or not defence.prediction:
            continue
        picture = subject.picture(
            "loo",
            f"Leave-one-out of {name}: expected log predictive density behind the best order's, "
            "with its paired standard error.",
            name,
        )
        table = Tabled(
            f"prediction-{name}",
            f"Leave-one-out of every order of {name}, nat.",
            prediction_table(axis, defence),
            tuple(prediction_lines(axis, defence)),
        )
        parts[name] = (picture, table)
    if not parts:
        return None
    return Section(
        "prediction",
        "Prediction",
        "Leave-one-out asks only how well an unseen pixel would have been predicted.",
        subject.parts(parts),
    )
