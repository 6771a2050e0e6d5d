"""Probabilities of joint models and the verdict across families."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from scipy.special import logsumexp

from bayescal.comparison.evidence import plausible_set, strength
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.finding import Finding, ordered
from bayescal.comparison.judged import log_weights
from bayescal.comparison.key import FREE, Key
from bayescal.comparison.verdict import Verdict
from bayescal.rounding import percent

NAMED = 4  # plausible models named beside the most probable one


@dataclass(frozen=True, kw_only=True, repr=False)
class FamilyVerdict(Verdict):
    """What to conclude of family, order and position together.

    Attributes
    ----------
    plausible : tuple of Key
        Smallest set, by falling probability, that reaches 0.95.
    families, positions : dict of str to float
        Probability of each family and of each treatment of the position.
    log_bayes_factor : float or None
        ln B of the best model against the best of any other family.
    """

    noun: ClassVar[str] = "model"
    nouns: ClassVar[str] = "models"

    best: Key
    plausible: tuple[Key, ...]
    families: dict[str, float]
    positions: dict[str, float]
    log_bayes_factor: float | None

    @property
    def recommended(self) -> str:
        """Name the most probable model."""
        return str(self.best)

    @property
    def others(self) -> str:
        """The most probable of the other plausible models, and how many more there are."""
        named = list(zip(self.plausible, self.chances, strict=True))[1:]
        more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
        return "; ".join(f"{key} ({percent(chance)})" for key, chance in named[:NAMED]) + more


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
    plausible = plausible_set({m.key: p for m, p in zip(models, chances, strict=True)})
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
        plausible=plausible,
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
