"""A run: a folder with the result document, the draws and the figures."""

from __future__ import annotations

import tempfile
from pathlib import Path

from bayescal.comparison.results import AxisComparison, Comparison, OrderResult
from bayescal.errors import OutputError
from bayescal.inference.arviz_bridge import write_netcdf

RESULT = "result.json"
DRAWS = "draws"


def check_run(folder: Path, *, force: bool) -> None:
    """Refuse, before any work is done, a place a run can't be written to.

    Raises
    ------
    OutputError
        Where something other than an earlier run stands there, or an earlier run
        without `force`, or the folder around it does not exist.
    """
    if folder.exists() or folder.is_symlink():
        if not (folder / RESULT).is_file():
            raise OutputError(f"{folder}: exists and is not a run; choose another name")
        if not force:
            raise OutputError(f"{folder}: holds an earlier run; choose another name or add --force")
    if not folder.absolute().parent.is_dir():
        raise OutputError(f"{folder}: there is no folder {folder.parent}; make it first")


def write_run(folder: Path, comparison: Comparison, result_json: str, *, force: bool) -> None:
    """Write a run, whole or not at all: made beside its place and then moved there.

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
    check_run(folder, force=force)
    try:
        with tempfile.TemporaryDirectory(
            dir=folder.absolute().parent, prefix=".bayescal-", ignore_cleanup_errors=True
        ) as temporary:
            made = Path(temporary) / "run"
            made.mkdir()
            (made / RESULT).write_text(result_json, encoding="utf-8")
            (made / DRAWS).mkdir()
            for name, axis in comparison.axes.items():
                for result in axis.orders:
                    _write_draws(made / DRAWS / f"{name}-order-{result.order}.nc", axis, result)
                _write_corner(made / f"corner-{name}.png", axis)
            if folder.exists():
                folder.rename(Path(temporary) / "earlier")
            made.rename(folder)
    except OSError as error:
        raise OutputError(f"{folder}: {(error.strerror or str(error)).lower()}") from None


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
    from bayescal.report.figures import corner_plot

    corner_plot(axis, axis.chosen).savefig(path, dpi=110)
