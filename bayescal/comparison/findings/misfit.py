"""Where the recommended order does not describe its points: misfit comes before all else.

The tests are those of the block of adequacy that cost next to nothing; their p-values are
adjusted for each other (Holm 1979). Below 0.05 a test limits the verdict, below 0.01 nothing is
decided beside it: the probabilities of orders rest on independent normal errors about a curve
of one coordinate, and the points contradict that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bayescal.arrays import Array
from bayescal.comparison.adequacy.coordinate import other_coordinate, other_coordinate_within
from bayescal.comparison.adequacy.groups import shared_errors
from bayescal.comparison.adequacy.level import chi_squared
from bayescal.comparison.adequacy.normality import normality
from bayescal.comparison.adequacy.outcome import GROUPS, AdequacyTest, adjusted, concerns
from bayescal.comparison.adequacy.problem import Problem
from bayescal.comparison.adequacy.replicates import lack_of_fit, lack_of_fit_scatter
from bayescal.comparison.axis import Axis
from bayescal.comparison.findings.case import Case
from bayescal.comparison.findings.finding import Finding, limits, overturns

# An adjusted p-value below which nothing is decided.
GRAVE = 0.01
# Degrees of freedom of replicates below which their sigma is hardly known.
FEW = 5
# In a few words, by the beginning of a test's name.
BECAUSE = {
    "chi2": "no order describes the points to within the known sigma",
    "lack of fit": "the order misses more than noise",
    "other coordinate": "residuals depend on the other coordinate",
    "shared errors": "points share errors",
    "normality": "the noise is not normal",
}


def misfit(case: Case) -> Iterator[Finding]:
    """Test the best order's residuals, where the noise is Gaussian."""
    if not case.gaussian:
        return
    yield from _of_all_orders(case)
    yield from concerning(
        cheap_tests(case.axis, case.best.order, case.other, case.depth, case.groups)
    )
    if case.reference.source == "replicates" and (case.reference.dof or 0) < FEW:
        yield limits(
            "few-replicates",
            f"the replicates have {case.reference.dof} degrees of freedom: their sigma is hardly "
            "known, and so are chi2 and lack of fit",
        )


def cheap_tests(
    axis: Axis,
    order: int,
    other: Array | None,
    depth: Array | None,
    groups: tuple[str, ...] | None,
    *,
    shape: bool = True,
) -> tuple[AdequacyTest, ...]:
    """Run the tests that cost next to nothing, that of the noise's `shape` among them or not."""
    problem = Problem(axis.data, axis.fit(order), axis.noise)
    tests = [
        chi_squared(problem),
        lack_of_fit(problem, other),
        lack_of_fit_scatter(problem, other),
        other_coordinate(problem, other),
        other_coordinate_within(problem, other),
        shared_errors(problem, groups, depth),
        normality(problem) if shape else None,
    ]
    return adjusted(test for test in tests if test is not None)


def concerning(tests: Sequence[AdequacyTest]) -> Iterator[Finding]:
    """Turn the concerns of a block of tests into findings, their words those of the block."""
    worrying = [test for test in tests if test.concern]
    lines = concerns(tests)
    for test, line in zip(worrying, lines, strict=False):
        because = next((words for name, words in BECAUSE.items() if test.name.startswith(name)), "")
        if because and test.p_adjusted is not None and test.p_adjusted < GRAVE:
            yield overturns(f"misfit: {test.name}", line, because)
        else:
            yield limits(f"misfit: {test.name}", line)
    yield from (limits(f"misfit: {GROUPS}", line) for line in lines[len(worrying) :])


def _of_all_orders(case: Case) -> Iterator[Finding]:
    """Say where chi-squared rejects every order at a known sigma."""
    known = [r.goodness for r in case.results if r.goodness.p_value is not None]
    values = [g.p_value for g in known if g.p_value is not None]
    if len(values) < 2 or max(values) >= GRAVE:
        return
    reduced = min(g.chi2_reduced or 0.0 for g in known)
    yield overturns(
        "chi-squared",
        f"chi-squared rejects every order at the known sigma (chi2/dof at least {reduced:.3g}): "
        "sigma is stated too small, or the model is not the right one",
        BECAUSE["chi2"],
    )
