"""What every joint candidate of r and c has in common: the data, and the way to its result."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.comparison.criteria.goodness import GoodnessOfFit
from bayescal.comparison.criteria.information import Criteria
from bayescal.comparison.criteria.leave_one_out import LeaveOneOut
from bayescal.comparison.criteria.psis import LeftOut, Without, sampled_leave_one_out
from bayescal.comparison.families.linearised import Linearised
from bayescal.comparison.families.models import (
    Wanted,
    joint_criteria,
    joint_data,
    joint_goodness,
    linear_residuals,
)
from bayescal.comparison.families.result import JointModel
from bayescal.comparison.key import Key
from bayescal.comparison.orders.axis import Axis, residuals
from bayescal.comparison.store import Store
from bayescal.density.joint_data import JointData
from bayescal.inference.sampled_posterior import SampledPosterior
from bayescal.inference.weighting import WeightedDraws
from bayescal.points.correspondences import Correspondences

# Share of the weight of all that one weighted draw may have: of its copies the tail that tells
# of a point left out would be made.
HEAVIEST = 0.02


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Criteria and chi-squared of a joint model at its highest likelihood."""

    criteria: Criteria
    goodness: GoodnessOfFit | None = None

    @classmethod
    def of(cls, data: JointData, rss: Array, k: int) -> Likelihood:
        """Collect what the weighted `rss` of each axis, ``(2,)``, says of `k` parameters."""
        return cls(joint_criteria(data, rss, k), joint_goodness(data, rss, k))


class Gaussian(Protocol):
    """What a candidate of Gaussian noise can say of itself without draws."""

    @property
    def key(self) -> Key:
        """Which it is."""
        ...

    @property
    def approximate(self) -> float:
        """Log evidence, in closed form or by Laplace's approximation."""
        ...

    def without_groups(self, members: Array) -> Array:
        """Give the same without each group, `members` ``(n_groups, n_points)``."""
        ...

    def linearised(self) -> Linearised:
        """About its highest likelihood."""
        ...


@dataclass(frozen=True, eq=False)
class LinearPair:
    """Both axes of a linear family, each of one order."""

    key: Key
    points: Correspondences
    axes: tuple[Axis, Axis]
    wanted: Wanted

    @property
    def parts(self) -> tuple[Key, Correspondences, tuple[Axis, Axis], Wanted]:
        """What a candidate begins with."""
        return self.key, self.points, self.axes, self.wanted

    @property
    def reduced(self) -> bool:
        """Whether these points are a sample, and all are known by their reduction."""
        return self.axes[0].data.whole is not None

    def at(self, position: Array) -> dict[str, Any]:
        """Give what a result says at a camera position: least squares' residuals there."""
        if self.reduced:  # of the sample, by the fit of all
            pairs = zip(self.axes, self.wanted.pair, strict=True)
            left = np.stack([residuals(axis.data, axis.fit(k)) for axis, k in pairs])
        else:
            left = linear_residuals(self.points, self.axes, self.wanted.pair, position)
        pixels = joint_data(self.axes).pixels
        return {"position": position, "pixels": pixels, "residuals": frozen(left)}


def judged_by(
    store: Store,
    key: Key,
    drawn: SampledPosterior | WeightedDraws,
    likelihood: Likelihood,
    left_out: LeftOut,
    without: Without | None = None,
    **named: Any,
) -> JointModel:
    """Say what draws, sampled or weighted, say of a candidate: its evidence and leave-one-out."""
    loo = None
    if drawn.heaviest <= HEAVIEST:
        find = partial(sampled_leave_one_out, drawn, left_out, without)
        loo = store.leave_one_out(key, find)
    kept = "weighted" if isinstance(drawn, WeightedDraws) else "posterior"
    return result_of(key, drawn, likelihood, loo, **{kept: drawn}, **named)


def result_of(
    key: Key,
    drawn: SampledPosterior | WeightedDraws,
    likelihood: Likelihood,
    loo: LeaveOneOut | None,
    **named: Any,
) -> JointModel:
    """Make the result of a model that has draws."""
    return JointModel(
        key=key,
        log_evidence=drawn.estimate.log_evidence,
        log_evidence_error=drawn.estimate.error,
        warnings=drawn.estimate.warnings,
        loo=loo,
        criteria=likelihood.criteria,
        goodness=likelihood.goodness,
        **named,
    )
