"""Which points are bad, and whether the choice of the order depends on them."""

from __future__ import annotations

from bayescal.comparison.outliers.results import AxisOutliers, OutlierStudy
from bayescal.report.figures import bad_points
from bayescal.report.noise import MARK, shape_words
from bayescal.report.outliers import footnotes, points_table, treatments_table
from bayescal.report.page.blocks import Block, Details, Facts, Listing, Part, Prose, Section, Tabled
from bayescal.report.page.subject import PageSubject, pictured
from bayescal.report.terminal import rule_words


def section(subject: PageSubject) -> Section | None:
    """Show the bad points where they were looked for."""
    return None if subject.study is None else study_section(subject.study)


def study_section(study: OutlierStudy) -> Section:
    """Show each axis's bad points in words, picture and numbers, and the orders without them.

    Parameters
    ----------
    study : OutlierStudy
    """
    parts = tuple(
        Part(f"Bad points of {axis.data.axis} as a polynomial of {axis.data.regressor}", blocks)
        for axis in study.axes.values()
        for blocks in (_blocks(axis, study),)
    )
    return Section(
        "bad-points",
        "Bad points",
        "Which readings should be looked at again, and would the order have been another without "
        "them?",
        parts,
    )


def _blocks(axis: AxisOutliers, study: OutlierStudy) -> tuple[Block, ...]:
    name, (heavy, mixture) = axis.data.axis, study.noises
    assumed = (
        ("sigma", axis.noise_source),
        ("heavy tails", shape_words(heavy, axis.data)),
        ("bad points", shape_words(mixture, axis.data)),
        ("prior", rule_words(axis.prior)),
    )
    shown = points_table(axis, everything=False)
    suspicious = {p.index for p in axis.suspicious}
    flagged = {i for i, row in enumerate(shown.rows) if row[0].value in suspicious}
    explained = axis.explanations or ("no point is suspicious",)
    found: list[Block] = [
        Prose(axis.verdict),
        Listing(tuple(f"{line[0].upper()}{line[1:]}." for line in explained)),
        pictured(
            f"figure-bad-points-{name}",
            bad_points.draw(axis),
            bad_points.alt_text(axis),
            f"Residuals of {name} at order {axis.order}, and the probability that each point is "
            "bad under the outlier mixture.",
        ),
        Tabled(
            f"bad-points-{name}",
            f"The most suspicious points of {name} at order {axis.order}; suspicious ones are "
            "marked.",
            shown,
            (footnotes(axis, study.significance, everything=True)[0],),
            frozenset(flagged),
        ),
    ]
    if len(shown.rows) < len(axis.points):
        every = Tabled(f"all-points-{name}", f"Every point of {name}.", points_table(axis))
        found.append(Details(f"Every point of {name}", (every,)))
    notes = [
        "Log evidence of each order. Evidences of fewer points are of other data: on that line "
        "orders can be compared, noise models can't."
    ]
    if not axis.sound:
        notes.append(f"{MARK} an evidence that should not be trusted.")
    return (
        *found,
        Tabled(
            f"treatments-{name}",
            f"Orders of {name} under each treatment of bad points.",
            treatments_table(axis),
            tuple(notes),
        ),
        Facts(assumed),
    )
