"""Whether a run says what is computed from its points and draws."""

from __future__ import annotations

import math
from typing import Any

# The closed form is good to this many nats, on any machine (docs/method.md).
NATS = 1e-6
# Beyond that, rounding of sums over many points, as a share of the number.
ROUNDING = 1e-10


def disagreement(kept: dict[str, Any], made: dict[str, Any]) -> str | None:
    """Name the first number that the run and the computation just made don't share."""
    for axis, was in kept["axes"].items():
        now = made["axes"][axis]
        for old, new in zip(was["orders"], now["orders"], strict=True):
            place = f"{axis}, order {old['order']}"
            for key, words in (
                ("log_evidence", "log evidence"),
                ("log_likelihood_max", "maximum of the log likelihood"),
                ("probability", "probability"),
            ):
                if not alike(old[key], new[key]):
                    return f"the {words} of {place} is {old[key]} in the run but {new[key]} now"
            for one, other in zip(old["coefficients"], new["coefficients"], strict=True):
                if abs(one["mean"] - other["mean"]) > NATS * one["sd"]:
                    return (
                        f"the mean of {one['name']} of {place} is {one['mean']} in the run but "
                        f"{other['mean']} from its draws"
                    )
        best, again = was["verdict"]["order"], now["verdict"]["order"]
        if best != again:
            return f"the order recommended for {axis} is {best} in the run but {again} now"
    return None


def alike(one: float | None, other: float | None) -> bool:
    """Whether two numbers are the same but for rounding, or both are missing."""
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=ROUNDING, abs_tol=NATS)
