"""Posterior probabilities of orders, and the words for their strength."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import TypeVar

# Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 777: 2 ln B up to each bound.
_SCALE = (
    (2.0, "not worth more than a bare mention"),
    (6.0, "positive"),
    (10.0, "strong"),
    (math.inf, "very strong"),
)
PLAUSIBLE = 0.95
Name = TypeVar("Name", bound=Hashable)


def probabilities(log_evidence: Sequence[float]) -> list[float]:
    """Posterior probabilities of models with equal prior probabilities.

    Parameters
    ----------
    log_evidence : sequence of float
        Natural logs.
    """
    best = max(log_evidence)
    odds = [math.exp(z - best) for z in log_evidence]
    total = math.fsum(odds)
    return [o / total for o in odds]


def strength(log_bayes_factor: float) -> str:
    """Words of Kass & Raftery for a log Bayes factor (not negative)."""
    return next(words for bound, words in _SCALE if 2 * log_bayes_factor <= bound)


def plausible_set(probability: Mapping[Name, float]) -> tuple[Name, ...]:
    """Smallest set, by falling probability, that reaches 0.95; of equals the first come first."""
    chosen: list[Name] = []
    total = 0.0
    for name in sorted(probability, key=lambda name: -probability[name]):
        chosen.append(name)
        total += probability[name]
        if total >= PLAUSIBLE:
            break
    return tuple(chosen)
