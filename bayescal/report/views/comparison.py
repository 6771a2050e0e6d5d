"""A comparison of orders as people see it: what is printed, and the chapters of its page."""

from __future__ import annotations

from bayescal.comparison.results import Comparison
from bayescal.report.blocks import Block, Blocks, Facts, Part, Prose, Section, Tabled, listed
from bayescal.report.views.orders import (
    adequacy,
    chains,
    coefficients,
    curve,
    evidence,
    methods,
    posterior,
    prediction,
    residuals,
    stability,
    table,
    verdict,
)
from bayescal.report.views.remember import remembered
from bayescal.report.views.views import Views, axis_title
from bayescal.report.views.words import distrust
from bayescal.rounding import grouped

# A topic is one module in orders/ and one line here.
TOPICS = (
    verdict.TOPIC,
    table.TOPIC,
    evidence.TOPIC,
    prediction.TOPIC,
    stability.TOPIC,
    adequacy.TOPIC,
)
APPENDIX = (residuals.TOPIC, curve.TOPIC, coefficients.TOPIC, posterior.TOPIC, chains.TOPIC)
# What the terminal shows of a defence, under headings of their own.
DEFENCE = (prediction.TOPIC, evidence.TOPIC, stability.TOPIC, adequacy.TOPIC)
UNSOUND = (
    "some draws did not converge or disagree with the closed form, or an evidence should not be "
    "trusted; see the sampling."
)


def brief(comparison: Comparison) -> Blocks:
    """Everything that ``compare`` prints."""
    blocks: list[Block] = [*header(comparison)]
    for axis in comparison.axes.values():
        part: list[Block] = []
        for topic in (table.TOPIC, verdict.TOPIC):
            part += topic.of_axis(comparison, axis)
        for topic in DEFENCE:
            found = topic.of_axis(comparison, axis)
            part += [Part(f"  {topic.title}", found)] if found else []
        part += coefficients.of_axis(comparison, axis)
        blocks.append(Part(axis_title(axis), tuple(part)))
    blocks += stability.both_axes(comparison)
    many = comparison.points is not None and comparison.points.drawn_from is not None
    if any(axis.defence is None for axis in comparison.axes.values()):
        noise = "" if many else "other noise, "
        more = f"leave-one-out, prior sensitivity, stability, adequacy, {noise}orders beyond"
        blocks.append(Prose(f"Would it persuade a referee? --defend adds {more}."))
    blocks += sampling(comparison)
    if all(axis.defence is not None for axis in comparison.axes.values()):
        verdicts = {name: axis.verdict for name, axis in comparison.axes.items()}
        blocks.append(remembered(verdicts))
    return tuple(blocks)


def full(comparison: Comparison) -> Blocks:
    """Everything that ``fit`` prints: each axis's one order in full."""
    blocks: list[Block] = [*header(comparison)]
    for axis in comparison.axes.values():
        (result,) = axis.orders
        numbers = coefficients.coefficients_table(axis, result, full=True)
        part = (
            Facts((*table.assumed(axis), *coefficients.facts(axis, result))),
            *verdict.of_axis(comparison, axis),
            Tabled(f"coefficients-{axis.data.axis}", "", numbers),
            coefficients.exact_tabled(axis, result),
        )
        blocks.append(Part(axis_title(axis), part))
    return (*blocks, *sampling(comparison))


def header(comparison: Comparison) -> Blocks:
    """Say what was analysed, under which assumptions."""
    return listed(about(comparison), "about")


def sampling(comparison: Comparison) -> Blocks:
    """Say whether the draws can be trusted, for all models at once."""
    words = Prose(chains.sampling_words(comparison), lead="Sampling")
    return words, *distrust(UNSOUND, sound=comparison.sound)


def about(comparison: Comparison) -> list[str]:
    """Points, camera and notes, a line each."""
    lines = []
    points = comparison.points
    if points is None:
        lines.append(f"{len(next(iter(comparison.axes.values())).data)} pairs of x and y")
    else:
        x, y, z = points.setup.position
        size = " x ".join(
            "?" if s is None else f"{s:g}" for s in (points.setup.width, points.setup.height)
        )
        end = "bottom (c = height - row)" if points.setup.c_from_bottom else "top"
        lines.append(f"{grouped(points.n)} points from {points.source}, {comparison.family} family")
        lines.append(f"camera at ({x:g}, {y:g}, {z:g}), image {size} px, c counted from the {end}")
    return lines + [f"note: {note}" for note in comparison.notes]


def headlines(comparison: Comparison) -> list[str]:
    """Name the order of each axis, and how it stands."""
    found = {name: axis.verdict for name, axis in comparison.axes.items()}
    return [
        f"{name}: {'; '.join((v.recommended, v.standing, *v.withheld[:1]))}"
        for name, v in found.items()
    ]


def title(comparison: Comparison) -> str:
    """Head a page."""
    if all(len(axis) == 1 for axis in comparison):
        return f"A {'polynomial' if comparison.points is None else 'camera calibration'} in full"
    if comparison.points is None:
        return "Which polynomial order? A comparison"
    return "Which polynomial order? A camera calibration compared"


def _maps(comparison: Comparison) -> Section | None:
    """Show the image's maps, which the terminal has no need of."""
    from bayescal.prediction.calibrated.orders import orders_camera
    from bayescal.report.views.maps import map_section

    return map_section(comparison, orders_camera)


VIEWS = Views(
    title,
    about,
    brief,
    full,
    headlines,
    {**{topic.id: topic.section for topic in TOPICS}, "maps": _maps},
    UNSOUND,
    {topic.id: topic.section for topic in APPENDIX},
    methods.section,
)
