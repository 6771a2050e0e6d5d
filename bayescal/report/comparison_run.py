"""A comparison of orders as a run: written, and reopened without sampling.

The draws are read; what has a closed form is computed again and checked.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bayescal.comparison.analysis import analyse_points, model_name
from bayescal.comparison.defence.noise_evidence import NoiseEvidence
from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.errors import InputError
from bayescal.inference.arviz_bridge import Draws
from bayescal.inference.posterior import Posterior, posterior_of
from bayescal.inference.stored import pack, pack_sampled, unpack
from bayescal.linear.closed_form import exact_posterior
from bayescal.linear.model import LinearModel
from bayescal.polynomials import separable
from bayescal.report.agreement import disagreement
from bayescal.report.document import SCHEMA, document
from bayescal.report.other_noises import noises_from
from bayescal.report.run import described, fill_run
from bayescal.report.run_files import RunFiles
from bayescal.report.shape import AXIS, DOCUMENT
from bayescal.version import __version__


def write_comparison(
    folder: Path, comparison: Comparison, result_json: str, *, force: bool
) -> None:
    """Write a comparison as a run, whole or not at all.

    Parameters
    ----------
    folder : Path
    comparison : Comparison
    result_json : str
        The result document.
    force : bool
        Replace an earlier run.

    Raises
    ------
    OutputError
        Where it can't be written; nothing is left behind.
    """
    points = comparison.points
    if points is None:
        raise InputError("a run holds world points and pixels; this comparison is of plain arrays")
    draws = {
        model_name(axis.data.axis, result.order): _draws(axis, result)
        for axis in comparison.axes.values()
        for result in axis.orders
    }

    def pictures(made: Path) -> None:
        for name in comparison.axes:
            _write_corner(made / f"corner-{name}.png", comparison, name)

    fill_run(folder, points, result_json, draws, pictures, force=force)


def open_comparison(folder: str | Path, *, defend: bool | None = None) -> Comparison:
    """Read a comparison back from the folder that `write_comparison` wrote.

    Nothing is sampled: the draws are read. What follows from points and draws without
    chance is computed again and compared with what the run says.

    Parameters
    ----------
    folder : str or Path
    defend : bool, optional
        Whether to answer a referee's questions too; by default where the run does.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        Where the folder is no run, was written by a version whose runs this one can't
        read, is incomplete, was changed, or says other numbers than computed now.
    """
    run = _Run.at(Path(folder))
    asked = run.settings()
    settings = asked
    if defend is not None:
        settings = dataclasses.replace(settings, defend=defend)
    comparison = analyse_points(run.points(), run.orders, settings, None, run)
    wrong = disagreement(run.document, document(comparison, ""))
    if wrong is not None:
        raise InputError(f"{run.folder}: {wrong}: {run.between()}; {run.again}")
    # With other answers than the run's it is no longer what the run holds.
    same = settings == asked
    hint = run.document.get("families", {}).get("hint")
    origin = run.document["provenance"] if same else None
    return dataclasses.replace(comparison, origin=origin, hint=hint)


def _draws(axis: AxisComparison, result: OrderResult) -> Draws:
    posterior = result.posterior
    draws = (
        pack(posterior.chain, posterior.names)
        if isinstance(posterior, Posterior)
        else pack_sampled(posterior)
    )
    return described(draws, axis.data, result.order)


def _write_corner(path: Path, comparison: Comparison, name: str) -> None:
    from bayescal.report.figures.registry import KINDS
    from bayescal.report.figures.style import figure_bytes

    path.write_bytes(figure_bytes(KINDS["corner"].draw(comparison, name), "png", dpi=150))


@dataclass(frozen=True, eq=False)
class _Run(RunFiles):
    """A comparison's run."""

    schema = SCHEMA
    made_by = "compare"
    shape = DOCUMENT
    axis_shape = AXIS

    @property
    def orders(self) -> dict[str, tuple[int, ...]]:
        """Orders compared, by axis."""
        family = self.document["family"]
        if family != separable.NAME:
            raise InputError(
                f"{self.folder}: is of the family {family!r}, which bayescal "
                f"{__version__} does not have ({self.between()}); upgrade bayescal"
            )
        axes = self.document["axes"]
        return {name: tuple(o["order"] for o in axis["orders"]) for name, axis in axes.items()}

    def posterior(
        self,
        name: str,
        model: LinearModel,
        compute: Callable[[], Posterior],  # noqa: ARG002 - nothing is sampled
    ) -> Posterior:
        """Read a model's draws (as a `bayescal.comparison.analysis.Source`)."""
        chain = self.read_draws(name, lambda draws: unpack(draws, model.names))
        return posterior_of(exact_posterior(model), chain)

    def noises(self, axis: str) -> tuple[NoiseEvidence, ...] | None:
        """Evidence under other noise models, where the run's defence has it."""
        defence = self.document["axes"][axis]["defence"]
        return None if defence is None else noises_from(defence["noises"])

    def wins(self, axis: str, unit: str) -> dict[int, float] | None:
        """Bootstrap shares of an axis, which take most of a defence's time."""
        defence = self.document["axes"][axis]["defence"]
        for found in defence["bootstrap"] if defence is not None else []:
            if found["unit"] == unit:
                return {int(k): share for k, share in found["share"].items()}
        return None
