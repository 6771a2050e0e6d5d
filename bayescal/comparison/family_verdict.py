"""Probabilities of joint models and the verdict across families."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bayescal.comparison.evidence import PLAUSIBLE, strength
from bayescal.comparison.families import FREE, FamilyVerdict, JointModel, ModelName
from bayescal.comparison.verdict import percent


def model_probabilities(models: Sequence[JointModel]) -> list[float]:
    """Posterior probabilities: families equal, within one its positions, within these orders.

    A family does not become more probable by offering more orders.
    """
    logs = []
    for model in models:
        name = model.name
        same = [m.name for m in models if m.name.family == name.family]
        positions = len({n.position for n in same})
        orders = sum(n.position == name.position for n in same)
        logs.append(model.log_evidence - math.log(positions * orders))
    top = max(logs)
    odds = [math.exp(value - top) for value in logs]
    total = math.fsum(odds)
    return [o / total for o in odds]


def judge_families(
    models: Sequence[JointModel], chances: Sequence[float], caveats: Sequence[str]
) -> FamilyVerdict:
    """Form the verdict across families.

    Parameters
    ----------
    models : sequence of JointModel
        The most probable first.
    chances : sequence of float
    caveats : sequence of str
    """
    best = models[0]
    plausible: list[ModelName] = []
    total = 0.0
    for model, chance in zip(models, chances, strict=True):
        plausible.append(model.name)
        total += chance
        if total >= PLAUSIBLE:
            break
    families, positions = (_shares(models, chances, key) for key in ("family", "position"))
    others = [m for m in models if m.name.family != best.name.family]
    factor = None
    if others:
        rival = max(others, key=lambda m: m.log_evidence)
        factor = best.log_evidence - rival.log_evidence
    text = f"{_sentence(best.name)} is the most probable model, {percent(chances[0])}; "
    if len(plausible) == 1:
        text += "decided at 95%."
    else:
        rest = "; ".join(f"{n} ({percent(chances[i])})" for i, n in enumerate(plausible[:5]) if i)
        more = f" and {len(plausible) - 5} more" if len(plausible) > 5 else ""
        text += f"not decided: {rest}{more} can't be excluded at 95%."
    if factor is not None and factor > 0:
        text += (
            f" Against the best of another family, {rival.name}: 2 ln B = {2 * factor:.1f}, "
            f"{strength(factor)} (Kass & Raftery)."
        )
    elif factor is not None:
        text += f" By evidence alone {rival.name} is ahead by {-factor:.1f} nat."
    if len(positions) > 1:
        free = positions.get(FREE, 0.0)
        text += (
            f" Summed over families and orders, a free camera position has {percent(free)}, the "
            f"stated one {percent(1 - free)}."
        )
    return FamilyVerdict(
        best.name,
        tuple(plausible),
        len(plausible) == 1,
        families,
        positions,
        factor,
        tuple(caveats),
        text,
    )


def _sentence(name: ModelName) -> str:
    words = str(name)
    return words[0].upper() + words[1:]


def _shares(models: Sequence[JointModel], chances: Sequence[float], key: str) -> dict[str, float]:
    out: dict[str, float] = {}
    for model, chance in zip(models, chances, strict=True):
        value = getattr(model.name, key)
        out[value] = out.get(value, 0.0) + chance
    return out
