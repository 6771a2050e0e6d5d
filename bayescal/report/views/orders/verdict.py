"""Which order, how sure, with which caveats: the whole report in half a page."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Answer, Answers, Blocks, Figure, Prose, listed
from bayescal.report.views.views import Topic


def of_axis(_: Comparison, axis: AxisComparison) -> Blocks:
    """Say the verdict in words, with its caveats."""
    verdict = Prose(axis.verdict.text, lead=f"Verdict on {axis.data.axis}")
    return verdict, *listed([f"{caveat}." for caveat in caveats(axis)], "caveat")


def at_a_glance(comparison: Comparison) -> Blocks:
    """Say what was found in large type and one picture."""
    return (
        Answers(tuple(_answer(axis) for axis in comparison.axes.values())),
        Figure(
            "verdict",
            comparison,
            "Posterior probability of each order. The plausible orders are the fewest that "
            "together reach 95%.",
        ),
    )


TOPIC = Topic(
    "verdict",
    "Verdict",
    "How much non-linearity do these points support?",
    of_axis,
    before=at_a_glance,
)


def caveats(axis: AxisComparison) -> list[str]:
    """Caveats of the verdict; the tests of adequacy that fail are one of them, told below."""
    if not axis.adequacy:
        return list(axis.verdict.caveats)
    from bayescal.comparison.adequacy.outcome import concerns

    said = set(concerns(axis.adequacy))
    found = [caveat for caveat in axis.verdict.caveats if caveat not in said]
    failed = [test.name for test in axis.adequacy if test.concern]
    if failed:
        found.append(
            f"order {axis.chosen.order} fails {len(failed)} of the tests of adequacy below: "
            f"{'; '.join(failed)}"
        )
    return found


def _answer(axis: AxisComparison) -> Answer:
    verdict, name = axis.verdict, f"{axis.data.axis}, in {axis.data.regressor}"
    found = "no order" if verdict.order is None else f"order {verdict.order}"
    return Answer(name, found, verdict.standing)
