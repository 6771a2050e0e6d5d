"""Which lenses stay plausible, and the verdict on them."""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.comparison.evidence import plausible_set, strength
from bayescal.comparison.finding import Finding, ordered
from bayescal.comparison.lenses.results import JudgedLens
from bayescal.comparison.lenses.verdict import TOLERANCE, LensVerdict
from bayescal.rounding import significant


def judge_lenses(
    lenses: Sequence[JudgedLens], findings: Sequence[Finding], bad: str = ""
) -> LensVerdict:
    """Form the verdict.

    Parameters
    ----------
    lenses : sequence of JudgedLens
        The most probable first.
    findings : sequence of Finding
        What stands against it or limits it.
    bad : str, optional
        What is said of bad points.
    """
    best, others = lenses[0], plausible_others(lenses)
    plausible = [best, *others]
    worth, beyond = (
        widest([getattr(j, name) for j in others])
        for name in ("inside_at_most", "difference_at_most")
    )
    verdict = LensVerdict(
        best=best.name,
        compared=len(lenses),
        plausible=tuple(j.name for j in plausible),
        chances=tuple(j.probability for j in plausible),
        simplest=min(plausible, key=lambda j: j.model.dimension).name,
        worth=worth,
        beyond=beyond,
        findings=ordered(findings),
        sentences=(),
    )
    return verdict.with_findings((), _runner_up(lenses, others), _further(verdict), bad)


def plausible_others(lenses: Sequence[JudgedLens]) -> list[JudgedLens]:
    """Lenses beside the most probable one, which is the first, that can't be excluded at 95 %."""
    plausible = plausible_set({j.name: j.probability for j in lenses})
    return [j for j in lenses[1:] if j.name in plausible]


def widest(gaps: Sequence[float | None]) -> float | None:
    """Give the largest of differences, px; None where there are none, or one is not known."""
    known = [g for g in gaps if g is not None]
    return max(known) if known and len(known) == len(gaps) else None


def _runner_up(lenses: Sequence[JudgedLens], others: Sequence[JudgedLens]) -> str:
    """Say how strong the evidence is against the next lens, where that one is excluded."""
    if len(lenses) == 1 or others:
        return ""
    factor = lenses[0].log_evidence - lenses[1].log_evidence
    return (
        f"Next is {lenses[1].name}, 2 ln B = {2 * factor:.1f}, {strength(factor)} (Kass & Raftery)."
    )


def _further(verdict: LensVerdict) -> str:
    """Say where lenses part that are alike where there are points."""
    if not verdict.enough or (verdict.beyond is not None and verdict.beyond <= TOLERANCE):
        return ""
    far = "an amount that can't be told"
    if verdict.beyond is not None:
        far = f"{significant(verdict.beyond)} px (95%)"
    return f"Beyond the points they may differ by {far}: photograph the target there."
