"""Which order, how sure, with which caveats: the whole report in half a page."""

from __future__ import annotations

from bayescal.comparison.results import AxisComparison
from bayescal.report.page.blocks import Answer, Answers, Block, Listing, Prose, Section
from bayescal.report.page.subject import PageSubject
from bayescal.report.terminal import caveats


def section(subject: PageSubject) -> Section:
    """Say what was found, in words and one picture."""
    blocks: list[Block] = [
        Answers(tuple(_answer(axis) for axis in subject.axes)),
        subject.picture(
            "verdict",
            "Posterior probability of each order. The plausible orders are the fewest that "
            "together reach 95%.",
        ),
        *subject.parts({axis.data.axis: _words(axis) for axis in subject.axes}),
    ]
    return Section(
        "verdict", "Verdict", "How much non-linearity do these points support?", tuple(blocks)
    )


def _answer(axis: AxisComparison) -> Answer:
    verdict, name = axis.verdict, f"{axis.data.axis}, in {axis.data.regressor}"
    if verdict.order is None:
        return Answer(name, "no order", verdict.standing)
    return Answer(name, f"order {verdict.order}", verdict.standing)


def _words(axis: AxisComparison) -> tuple[Block, ...]:
    blocks: list[Block] = [Prose(axis.verdict.text)]
    found = [f"Caveat: {caveat}." for caveat in caveats(axis)]
    concerns = [test.name for test in axis.adequacy if test.concern]
    if concerns:
        found.append(
            f"Caveat: order {axis.chosen.order} fails {len(concerns)} of the tests of adequacy "
            f"below: {'; '.join(concerns)}."
        )
    if found:
        blocks.append(Listing(tuple(found), "caveat"))
    return tuple(blocks)
