"""A run in place of the sampler: draws are read where they would be computed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bayescal.comparison.key import Key
from bayescal.comparison.store import Store
from bayescal.inference.sampled_model import SampledModel
from bayescal.inference.stored import unpacked
from bayescal.linear.model import LinearModel
from bayescal.noise.gaussian import GAUSSIAN
from bayescal.report.run.files import RunFiles

if TYPE_CHECKING:
    from bayescal.comparison.store import Kept


class StoredDraws(Store):
    """The draws of a run, in whose files' names the noise that is `usual` there is left out."""

    def __init__(self, run: RunFiles, usual: str = GAUSSIAN.name) -> None:
        super().__init__()
        self.run, self.usual = run, usual

    def read(self, key: Key, model: LinearModel | SampledModel, *, beside: bool) -> Kept | None:
        """Read the draws of a model; None where it stands `beside` and the run kept none."""
        name = key.file(self.usual)
        if beside and not self.run.keeps_draws(name):
            return None
        return self.run.read_draws(name, lambda draws: unpacked(draws, model))

    def known(self, name: str, kind: Any) -> tuple[Any] | None:
        """Read a value that took long; None where the run kept none of that name."""
        return self.run.derived_value(name, kind)
