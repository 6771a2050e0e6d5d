"""Probabilities of joint models and the verdict across families."""

from __future__ import annotations

from collections.abc import Sequence

from scipy.special import logsumexp

from bayescal.comparison.evidence import PLAUSIBLE, strength
from bayescal.comparison.families.results import FamilyVerdict, JointModel
from bayescal.comparison.findings.finding import Finding, ordered
from bayescal.comparison.judged import log_weights
from bayescal.comparison.key import FREE, Key
from bayescal.comparison.verdict import percent


def _between_families(models: Sequence[JointModel], families: dict[str, float]) -> str:
    """Say how probable each family is; nothing where there is one.

    The evidence of a family is that of its models, averaged over its positions and orders: the
    best of many models against the best of few would favour the many.
    """
    if len(families) < 2:
        return ""
    by_family: dict[str, list[float]] = {}
    for model, weight in zip(models, log_weights(models) or [], strict=True):
        by_family.setdefault(model.key.family, []).append(weight)
    logs = {family: float(logsumexp(weights)) for family, weights in by_family.items()}
    ranked = sorted(logs, key=lambda family: -logs[family])
    first, second = ranked[:2]
    factor = logs[first] - logs[second]
    shares = ", ".join(f"{family} {percent(families[family])}" for family in ranked)
    return (
        f"Between families, positions and orders averaged: {shares}; 2 ln B of {first} against "
        f"{second} = {2 * factor:.1f}, {strength(factor)} (Kass & Raftery)."
    )


def judge_families(models: Sequence[JointModel], findings: Sequence[Finding]) -> FamilyVerdict:
    """Form the verdict across families, from models of which the most probable is the first."""
    best, chances = models[0], [m.probability or 0.0 for m in models]
    plausible: list[Key] = []
    total = 0.0
    for model, chance in zip(models, chances, strict=True):
        plausible.append(model.key)
        total += chance
        if total >= PLAUSIBLE:
            break
    families, positions = (_shares(models, chances, key) for key in ("family", "position"))
    others = [m for m in models if m.key.family != best.key.family]
    factor = None
    if others:
        rival = max(others, key=lambda m: m.log_evidence)
        factor = best.log_evidence - rival.log_evidence
    said = [_between_families(models, families)]
    # Where each family has a position of its own, it says nothing that the family does not.
    if len({(m.key.family, m.key.position) for m in models}) > len(families):
        free = positions.get(FREE, 0.0)
        said.append(
            f"Summed over families and orders, a free camera position has {percent(free)}, the "
            f"stated one {percent(1 - free)}."
        )
    return FamilyVerdict(
        best=best.key,
        compared=len(models),
        plausible=tuple(plausible),
        chances=tuple(chances[: len(plausible)]),
        families=families,
        positions=positions,
        log_bayes_factor=factor,
        findings=ordered(findings),
        sentences=tuple(filter(None, said)),
    )


def _shares(models: Sequence[JointModel], chances: Sequence[float], key: str) -> dict[str, float]:
    out: dict[str, float] = {}
    for model, chance in zip(models, chances, strict=True):
        value = getattr(model.key, key)
        out[value] = out.get(value, 0.0) + chance
    return out
