"""The verdict across lens models, in plain words."""

from __future__ import annotations

from collections.abc import Sequence

from bayescal.comparison.evidence import PLAUSIBLE, strength
from bayescal.comparison.lenses.results import JudgedLens, LensVerdict
from bayescal.comparison.verdict import percent
from bayescal.rounding import significant

TOLERANCE = 0.1  # px: lenses that differ by less are alike for nearly any use


def _widest(gaps: Sequence[float | None]) -> float | None:
    known = [g for g in gaps if g is not None]
    return max(known) if known and len(known) == len(gaps) else None


def judge_lenses(lenses: Sequence[JudgedLens], caveats: Sequence[str]) -> LensVerdict:
    """Form the verdict.

    Parameters
    ----------
    lenses : sequence of JudgedLens
        The most probable first.
    caveats : sequence of str
    """
    best = lenses[0]
    plausible: list[JudgedLens] = []
    total = 0.0
    for judged in lenses:
        plausible.append(judged)
        total += judged.probability
        if total >= PLAUSIBLE:
            break
    others = plausible[1:]
    worth, beyond = (
        _widest([getattr(j, name) for j in others]) for name in ("inside", "difference")
    )
    status = "undecided"
    if len(lenses) == 1:
        status, text = "single", f"{best.name} is the only lens compared."
    elif not others:
        status = "decided"
        second = lenses[1]
        factor = best.log_evidence - second.log_evidence
        text = (
            f"These views support {best.name}, {percent(best.probability)}: decided at 95%. Next "
            f"is {second.name}, 2 ln B = {2 * factor:.1f}, {strength(factor)} (Kass & Raftery)."
        )
    else:
        names = ", ".join(f"{j.name} ({percent(j.probability)})" for j in others)
        lead = f"{best.name} is the most probable, {percent(best.probability)}; "
        if worth is not None and worth <= TOLERANCE:
            status = "suffices"
            simplest = min(plausible, key=lambda j: j.model.dimension)
            text = (
                f"{lead}{names} can't be excluded, but predict the same within "
                f"{significant(worth)} px where there are points: {simplest.name} suffices there."
            )
            if beyond is None or beyond > TOLERANCE:
                far = "" if beyond is None else f", by up to {significant(beyond)} px"
                text += f" Beyond the points they part{far}: photograph the target there."
        else:
            by = (
                "an amount that can't be told"
                if worth is None
                else f"up to {significant(worth)} px"
            )
            text = (
                f"Undecided, and it matters: {lead}{names} can't be excluded at 95%, and "
                f"predictions differ by {by} where there are points."
            )
    return LensVerdict(
        best.name, tuple(j.name for j in plausible), status, worth, beyond, tuple(caveats), text
    )
