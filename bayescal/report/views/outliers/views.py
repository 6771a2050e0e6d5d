"""An analysis of bad points as people see it: which points, and whether they choose the order."""

from __future__ import annotations

from bayescal.comparison.outliers.results import AxisOutliers, OutlierStudy
from bayescal.report.blocks import (
    Answer,
    Answers,
    Block,
    Blocks,
    Details,
    Facts,
    Figure,
    Listing,
    Part,
    Prose,
    Section,
    Tabled,
    listed,
)
from bayescal.report.views.outliers.tables import points_table, treatments_table
from bayescal.report.views.views import Views
from bayescal.report.views.words import MARK, distrust, floor_words, prior_words, shape_words
from bayescal.rounding import counted, percent

UNSOUND = f"{MARK} marks an evidence that should not be trusted, or chains that did not converge."
NAMED = 6  # suspicious points under the large type


def brief(study: OutlierStudy, *, everything: bool = False) -> Blocks:
    """Everything that ``outliers`` prints; every point where asked for."""
    blocks: list[Block] = [Listing(tuple(about(study)), "about")]
    for axis in study.axes.values():
        shown = points(axis, study, everything=everything)
        told = explained(axis), treatments(axis), *verdict(axis)
        blocks.append(Part(_title(axis), (*model_first(axis), shown, *told)))
    return (*blocks, *distrust(UNSOUND, sound=study.sound))


def section(study: OutlierStudy) -> Section:
    """Show each axis's bad points in words, picture and numbers, and the orders without them."""
    return Section(
        "bad-points",
        "Bad points",
        "Which readings should be looked at again, and would the order have been another without "
        "them?",
        (
            Answers(tuple(map(_answer, study.axes.values()))),
            *(Part(_title(axis), _blocks(axis, study)) for axis in study.axes.values()),
        ),
    )


def _answer(axis: AxisOutliers) -> Answer:
    """Say in large type how many points are suspicious, which, and what that does to the order."""
    labels, count = [p.label for p in axis.suspicious[:NAMED]], len(axis.suspicious)
    labels += [f"{count - NAMED} more"] * (count > NAMED)
    standing = axis.verdict.partition(". ")[0]
    return Answer(
        f"{axis.data.axis}, in {axis.data.regressor}",
        counted(count, "suspicious point") if count else "no suspicious point",
        f"{', '.join(labels)}. {standing}" if labels else standing,
        tuple(dict.fromkeys(f.because for f in axis.findings if f.withholds)),
    )


def about(study: OutlierStudy) -> list[str]:
    """Name the points."""
    return [f"{len(study.points)} points from {study.points.source}"]


def headlines(study: OutlierStudy) -> list[str]:
    """Give the verdict of each axis, and what is against the model before it."""
    return [f"{name}: {axis.headline}" for name, axis in study.axes.items()]


VIEWS = Views(
    lambda _: "Bad points of a camera calibration",
    about,
    brief,
    lambda study: brief(study, everything=True),
    headlines,
    {"bad points": section},
    UNSOUND,
)


def _title(axis: AxisOutliers) -> str:
    return f"Bad points of {axis.data.axis} as a polynomial of {axis.data.regressor}"


def _blocks(axis: AxisOutliers, study: OutlierStudy) -> Blocks:
    name, (heavy, mixture) = axis.data.axis, study.noises
    every = Tabled(f"all-points-{name}", f"Every point of {name}.", points_table(axis))
    assumed = (
        ("sigma", axis.noise_source),
        ("heavy tails", shape_words(heavy, axis.data)),
        ("bad points", shape_words(mixture, axis.data)),
        ("prior", prior_words(axis.prior)),
    )
    figure = Figure(
        "bad-points",
        study,
        f"Residuals of {name} at order {axis.order}, and the probability that each point is "
        "bad under the outlier mixture.",
        name,
    )
    shown = points(axis, study)
    folded = len(shown.table.rows) < len(axis.points)
    return (
        *model_first(axis),
        *verdict(axis),
        explained(axis),
        figure,
        shown,
        *((Details(f"Every point of {name}", (every,)),) if folded else ()),
        treatments(axis),
        Facts(assumed),
    )


def model_first(axis: AxisOutliers) -> Blocks:
    """Say what is against the model, before any point is called bad."""
    found = axis.against_the_model
    if not found:
        return ()
    lead = "a curve that misses makes good points look bad."
    return Prose(lead, lead="Look at the model first"), Listing(
        tuple(f"{f}." for f in found), "concern"
    )


def explained(axis: AxisOutliers) -> Listing:
    """Say what is known of the suspicious points."""
    lines = axis.explanations or ("no point is suspicious",)
    return Listing(tuple(f"{line[0].upper()}{line[1:].rstrip('.')}." for line in lines))


def points(axis: AxisOutliers, study: OutlierStudy, *, everything: bool = False) -> Tabled:
    """Show the most suspicious points, or every one."""
    name, shown = axis.data.axis, points_table(axis, everything=everything)
    suspicious = {p.index for p in axis.suspicious}
    return Tabled(
        f"bad-points-{name}",
        f"The most suspicious points of {name} at order {axis.order}; suspicious ones are marked.",
        shown,
        (footnote(axis, study.significance),),
        legend=_hidden(axis, len(shown.rows)),
        flagged=frozenset(i for i, row in enumerate(shown.rows) if row[0].value in suspicious),
    )


def verdict(axis: AxisOutliers) -> Blocks:
    """Say whether the bad points choose the order, and what limits that."""
    caveats = listed([f"{caveat}." for caveat in axis.caveats], "caveat")
    return Prose(axis.verdict, lead=f"Verdict on {axis.data.axis}"), *caveats


def treatments(axis: AxisOutliers) -> Tabled:
    """Show the orders under each treatment of bad points."""
    name = axis.data.axis
    notes = (
        "ln Z of each order. Evidences of fewer points are of other data: on that line orders can "
        "be compared, noise models can't.",
        *(() if axis.sound else (UNSOUND,)),
    )
    caption = f"Log evidence of the orders of {name} under each treatment of bad points."
    return Tabled(f"treatments-{name}", caption, treatments_table(axis), notes)


def footnote(axis: AxisOutliers, significance: float) -> str:
    """Say what the table of the points does not."""
    winner = axis.treatments[0]
    values = winner.log_evidence
    rest = [v for k, v in values.items() if k != winner.order]
    words = (
        f"Order {axis.order}, sigma {axis.noise_source}. Residual, its standard deviations, "
        "leverage and Cook: least squares of all points. Off, P(bad) and the sentences "
        "below: the outlier mixture, whose curve bad points hardly pull; ± of a prediction: of "
        "that curve, without the noise of a reading. Weight t: Student-t noise; rejected: "
        f"chi-squared test, {100 * significance:g}% for all points together."
        f"{floor_words(axis.data, axis.level)}"
    )
    if not rest:
        return words
    return (
        f"{words} ln B without: of order {winner.order} under Gaussian noise, "
        f"{values[winner.order] - max(rest):+.1f} with all points."
    )


def _hidden(axis: AxisOutliers, shown: int) -> tuple[str, ...]:
    """Say how bad the points are that a short table leaves out."""
    others = axis.points[shown:]
    if not others:
        return ()
    largest = max(abs(p.standardised or 0.0) for p in others)
    most = max(p.bad_probability for p in others)
    return (
        f"The other {counted(len(others), 'point')}: at most {largest:.1f} standard deviations, "
        f"P(bad) at most {percent(most)}; --all shows them.",
    )
