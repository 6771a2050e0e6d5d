"""A candidate, judged: what every comparison is made of."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from bayescal.comparison.evidence import probabilities
from bayescal.comparison.key import Key

if TYPE_CHECKING:  # a hint, which samples nothing, does not pay for what is sampled
    from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
    from bayescal.inference.posterior import Posterior


@dataclass(frozen=True, eq=False, kw_only=True)
class Weighed:
    """What the evidence of a candidate is.

    Attributes
    ----------
    log_evidence : float or None
        Natural log; None under a flat prior.
    log_evidence_error : float or None
        Monte Carlo error, or the quadrature's, nat.
    warnings : tuple of str
        Why the evidence should not be trusted; empty where it can be.
    """

    key: Key
    log_evidence: float | None
    log_evidence_error: float | None
    warnings: tuple[str, ...] = ()

    @property
    def weighed(self) -> Weighed:
        """The evidence alone, without draws."""
        return Weighed(
            key=self.key,
            log_evidence=self.log_evidence,
            log_evidence_error=self.log_evidence_error,
            warnings=self.warnings,
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Judged(Weighed):
    """What evidence and draws say of a candidate.

    Attributes
    ----------
    posterior : Posterior or None
        None of a model that was not sampled.
    loo : LeaveOneOut or None
        None where it was not asked for, or is unavailable.
    probability : float or None
        Posterior probability among those compared; None under a flat prior.
    """

    posterior: Posterior | None = None
    loo: LeaveOneOut | None = None
    probability: float | None = None

    @property
    def sound(self) -> bool:
        """Whether its draws, if any, converged, and its evidence can be trusted."""
        return not self.warnings and (self.posterior is None or self.posterior.sound)


Found = TypeVar("Found", bound=Judged)


def with_probabilities(found: Sequence[Found]) -> tuple[Found, ...]:
    """Give each its probability among all; as they are where a prior has no evidence."""
    weights = log_weights(found)
    if weights is None:
        return tuple(found)
    chances = probabilities(weights)
    return tuple(
        dataclasses.replace(one, probability=p) for one, p in zip(found, chances, strict=True)
    )


def log_weights(found: Sequence[Judged]) -> list[float] | None:
    """Log evidence of each times its prior probability; None where a prior has no evidence.

    Families are equally probable, within one its positions, within these its orders: a family
    does not become more probable by offering more orders.
    """
    kinds = Counter((one.key.family, one.key.position) for one in found)
    positions = Counter(family for family, _ in kinds)
    out = []
    for one in found:
        if one.log_evidence is None:
            return None
        kind = one.key.family, one.key.position
        alike = positions[kind[0]] * kinds[kind]
        out.append(one.log_evidence - math.log(alike) * (len(kinds) > 1))
    return out
