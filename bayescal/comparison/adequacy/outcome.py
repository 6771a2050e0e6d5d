"""The result of one adequacy test, and what a block of them says together."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

# A test is a concern where its Holm-adjusted p-value is below this: the chance of
# any false concern in the block of one axis is then at most 5 %.
LEVEL = 0.05


@dataclasses.dataclass(frozen=True)
class AdequacyTest:
    """One check of a fitted order.

    Attributes
    ----------
    statistic : str or None
        Name of the statistic: ``"F"``, ``"chi2"``, ``"LM"``, ``"ppp"``...; None
        where the test does not apply.
    value : float or None
        Its value; None where it does not apply or is infinite.
    dof : tuple of int or None
        Its degrees of freedom.
    p_value : float or None
        Uniform (or, of a discrete statistic, not smaller) where the model holds
        and errors are independent; None where there is none. A posterior
        predictive probability is not one.
    meaning : str
        One sentence with the numbers in it; of a test that does not apply, why.
    concern : bool
        Whether the user should worry.
    p_adjusted : float or None
        p-value adjusted for the other tests of the block (Holm 1979).
    parts : tuple of AdequacyTest
        Single tests that a joint test is made of; not counted in the block.
    """

    name: str
    statistic: str | None
    value: float | None
    dof: tuple[int, ...] | None
    p_value: float | None
    meaning: str
    concern: bool = False
    p_adjusted: float | None = None
    parts: tuple[AdequacyTest, ...] = ()


def untested(name: str, why: str) -> AdequacyTest:
    """Report a test that does not apply."""
    return AdequacyTest(name, None, None, None, None, why)


def holm(p_values: Sequence[float]) -> list[float]:
    """Adjust p-values for each other, at any dependence (Holm 1979, Scand. J. Stat. 6, 65)."""
    adjusted = [0.0] * len(p_values)
    largest = 0.0
    for rank, i in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted


def adjusted(tests: Iterable[AdequacyTest]) -> tuple[AdequacyTest, ...]:
    """Adjust the p-values of a block; a concern is an adjusted one below 0.05."""
    tests = tuple(tests)
    counted = [i for i, test in enumerate(tests) if test.p_value is not None]
    found = dict(zip(counted, holm([tests[i].p_value or 0.0 for i in counted]), strict=True))
    return tuple(
        dataclasses.replace(test, p_adjusted=found[i], concern=test.concern or found[i] < LEVEL)
        if i in found
        else test
        for i, test in enumerate(tests)
    )


def concerns(tests: Sequence[AdequacyTest]) -> list[str]:
    """Caveats of a block of tests, one line each, without a full stop.

    Each says its p-value after Holm's adjustment over the block. The tests assume
    independent errors: where errors are shared within groups the last line says
    what that does to the other p-values.
    """
    count = sum(test.p_value is not None for test in tests)
    lines = []
    for test in tests:
        if not test.concern:
            continue
        line = f"{test.name}: {test.meaning.rstrip('.')}"
        if test.p_adjusted is not None:
            line += f" ({p_words(test.p_adjusted)} after Holm over {count} tests)"
        lines.append(line)
    worrying = [test for test in tests if test.concern and test.p_value is not None]
    shared = [test for test in worrying if test.name.startswith(GROUPS)]
    if 0 < len(shared) < len(worrying):
        lines.append(
            "the p-values of the other checks assume independent errors, which points that share "
            "a group do not have: read them as too small"
        )
    return lines


GROUPS = "shared errors in groups"


def p_words(p: float) -> str:
    """Say a p-value in words that fit a sentence."""
    return "p < 0.0001" if p < 1e-4 else f"p = {p:.2g}"
