"""Which order, how sure, with which caveats: the whole report in half a page."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison, Comparison
from bayescal.report.blocks import Answer, Answers, Blocks, Figure
from bayescal.report.views.views import Topic
from bayescal.report.views.words import doubts, verdict_blocks


def of_axis(_: Comparison, axis: AxisComparison) -> Blocks:
    """Say the verdict in words, with its caveats."""
    return verdict_blocks(axis.verdict, f"Verdict on {axis.data.axis}")


def at_a_glance(comparison: Comparison) -> Blocks:
    """Say what was found in large type and one picture."""
    answers = Answers(tuple(_answer(axis) for axis in comparison))
    if all(len(axis) == 1 for axis in comparison):  # nothing to compare
        return (answers,)
    caption = (
        "Posterior probability of each order. The plausible orders are the fewest that together "
        "reach 95%."
    )
    return answers, Figure("verdict", comparison, caption)


TOPIC = Topic(
    "verdict",
    "Verdict",
    "How much non-linearity do these points support?",
    of_axis,
    before=at_a_glance,
)


def _answer(axis: AxisComparison) -> Answer:
    verdict, name = axis.verdict, f"{axis.data.axis}, in {axis.data.regressor}"
    return Answer(name, verdict.recommended, verdict.standing, doubts(verdict))
