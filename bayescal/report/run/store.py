"""A run in place of the sampler: draws are read where they would be computed."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from bayescal.arrays import frozen
from bayescal.comparison.defence.stability import Beyond
from bayescal.comparison.key import Key
from bayescal.comparison.leave_one_out import LeaveOneOut
from bayescal.comparison.store import Store
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.stored import unpacked
from bayescal.linear.model import LinearModel
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.report.document.defence import noises_from
from bayescal.report.run.files import RunFiles

if TYPE_CHECKING:
    from bayescal.comparison.judged import Judged
    from bayescal.comparison.store import Kept

LEFT_OUT = "leave_one_out"


class StoredDraws(Store):
    """The draws of a run, in whose files' names the noise that is `usual` there is left out."""

    def __init__(self, run: RunFiles, usual: str = GAUSSIAN.name) -> None:
        super().__init__()
        self.run, self.usual = run, usual
        self._left_out: dict[Key, LeaveOneOut | None] = {}

    def read(self, key: Key, model: LinearModel | SampledModel, *, beside: bool) -> Kept | None:
        """Read the draws of a model; None where it stands `beside` and the run kept none."""
        name = key.file(self.usual)
        if beside and not self.run.keeps_draws(name):
            return None

        def unpack(draws: Draws) -> Kept:
            if LEFT_OUT in draws.values:
                self._left_out[key] = _left_out(draws.values[LEFT_OUT])
            return unpacked(draws, model)

        return self.run.read_draws(name, unpack)

    def leave_one_out(
        self, key: Key, compute: Callable[[], LeaveOneOut | None]
    ) -> LeaveOneOut | None:
        """Give the leave-one-out that was kept beside a model's draws; older runs kept none."""
        return self._left_out[key] if key in self._left_out else compute()

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:
        """Bootstrap shares of an axis, which take most of a defence's time."""
        for found in self._defence(axis).get("bootstrap", []):
            if found["unit"] == unit:
                return {int(k): share for k, share in found["share"].items()}
        return None

    def beyond(self, axis: str, highest: int) -> Beyond | None:
        """Orders above the compared range, which without a closed form are sampled."""
        found = self._defence(axis).get("beyond")
        if found is None:
            return None
        chances = {int(k): p for k, p in found["probability"].items()}
        return Beyond(chances, found["winner"], tuple(k for k in chances if k > highest))

    def noises(self, axis: str) -> tuple[Judged, ...] | None:
        """Evidence under other noise models, where the run's defence has it."""
        rows = self._defence(axis).get("noises")
        return None if rows is None else noises_from(rows, axis)

    def _defence(self, axis: str) -> dict[str, Any]:
        """Give the defence of an axis; empty where it has none."""
        return self.run.document["axes"][axis].get("defence") or {}


def with_left_out(draws: Draws, loo: LeaveOneOut | None) -> Draws:
    """Keep a model's leave-one-out beside its draws: refits and smoothing take long."""
    draws.values[LEFT_OUT] = None if loo is None else {k: _plain(v) for k, v in vars(loo).items()}
    return draws


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _left_out(kept: dict[str, Any] | None) -> LeaveOneOut | None:
    """Undo it, to the last bit; ValueError where something is missing."""
    if kept is None:
        return None
    try:
        shape = kept["pareto_k"]
        return LeaveOneOut(
            frozen(kept["pointwise"]),
            kept["p_eff"],
            tuple(kept["refitted"]),
            None if shape is None else frozen(shape),
            kept["k_limit"],
            kept["mcse"],
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"lacks {error}") from None
