"""Where the recommended order does not describe its points: misfit comes before all else.

The tests are those of the block of adequacy, their p-values adjusted for each other (Holm 1979).
Below 0.05 a test limits the verdict, below 0.01 nothing is
decided beside it: the probabilities of orders rest on independent normal errors about a curve
of one coordinate, and the points contradict that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from bayescal.comparison.adequacy.outcome import GROUPS, AdequacyTest, concerns
from bayescal.comparison.finding import Finding, limits, overturns
from bayescal.comparison.findings.case import Case

# An adjusted p-value below which nothing is decided.
GRAVE = 0.01
# Degrees of freedom of replicates below which their sigma is hardly known.
FEW = 5
# In a few words, by the beginning of a test's name.
BECAUSE = {
    "chi2": "it does not describe the points to within the known sigma",
    "lack of fit": "residuals exceed the noise",
    "other coordinate": "residuals depend on the other coordinate",
    "shared errors": "points share errors",
    "normality": "the noise is not normal",
    "surface": "residuals depend on the place in the image",
    "neighbours": "neighbouring residuals are alike",
}


def misfit(case: Case) -> Iterator[Finding]:
    """Find what the tests of the best order's residuals say, where the noise is Gaussian."""
    if not case.gaussian:
        return
    because = BECAUSE["chi2"]
    for found in _of_all_orders(case):
        yield found
        because = found.because
    for found in concerning(case.tests):
        yield replace(found, because=because) if found.because == BECAUSE["chi2"] else found
    if case.reference.source == "replicates" and (case.reference.dof or 0) < FEW:
        yield limits(
            "few-replicates",
            f"the replicates have {case.reference.dof} degrees of freedom: their sigma is hardly "
            "known, and so are chi2 and lack of fit",
        )


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


def rejected(models: str, reduced: str, because: str = BECAUSE["chi2"]) -> Finding:
    """Make the finding that chi-squared rejects models; `reduced` says their chi2/dof."""
    return overturns(
        "chi-squared",
        f"chi-squared rejects {models} at the known sigma (chi2/dof {reduced}): sigma is stated "
        "too small, or the model is not the right one",
        because,
    )


def _of_all_orders(case: Case) -> Iterator[Finding]:
    """Say where chi-squared rejects every order at a known sigma."""
    known = [r.goodness for r in case.results if r.goodness.p_value is not None]
    values = [g.p_value for g in known if g.p_value is not None]
    if not values or max(values) >= GRAVE:
        return
    reduced = f"{min(g.chi2_reduced or 0.0 for g in known):.3g}"
    if len(case.results) == 1:
        yield rejected(f"order {case.best.order}", reduced)
    else:
        why = "no order describes the points to within the known sigma"
        yield rejected("every order", f"at least {reduced}", why)
