"""A run: a folder with the result document, the draws and the figures."""

from __future__ import annotations

from pathlib import Path

from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.files import FolderKind, check_folder, write_folder
from bayescal.inference.arviz_bridge import write_netcdf

RESULT = "result.json"
DRAWS = "draws"
RUN = FolderKind("run", RESULT, (DRAWS, "corner-*.png"))


def check_run(folder: Path, *, force: bool) -> None:
    """Refuse, before any work is done, a place a run can't be written to.

    Raises
    ------
    OutputError
        Where something other than an earlier run stands there, or an earlier run
        without `force`, or the folder around it does not exist.
    """
    check_folder(folder, RUN, force=force)


def write_run(folder: Path, comparison: Comparison, result_json: str, *, force: bool) -> None:
    """Write a run, whole or not at all.

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

    def fill(made: Path) -> None:
        (made / RESULT).write_text(result_json, encoding="utf-8")
        (made / DRAWS).mkdir()
        for name, axis in comparison.axes.items():
            for result in axis.orders:
                _write_draws(made / DRAWS / f"{name}-order-{result.order}.nc", axis, result)
            _write_corner(made / f"corner-{name}.png", axis)

    write_folder(folder, RUN, fill, force=force)


def _write_draws(path: Path, axis: AxisComparison, result: OrderResult) -> None:
    chain = result.posterior.chain
    write_netcdf(
        path,
        {name: chain.draws[:, :, j] for j, name in enumerate(result.posterior.names)},
        {"lp": chain.log_prob},
        {"pixel": axis.data.t, "regressor": axis.data.x},
        {
            "axis": axis.data.axis,
            "regressor": axis.data.regressor,
            "order": result.order,
            "units": "coefficients and sigma in px, tau a fraction of the image",
            "inference_library": "emcee",
        },
    )


def _write_corner(path: Path, axis: AxisComparison) -> None:
    from bayescal.report.figures.corner import corner_plot

    corner_plot(axis, axis.chosen).savefig(path, dpi=110)
