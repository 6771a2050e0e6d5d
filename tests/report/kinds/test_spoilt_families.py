"""A run of families that was damaged, edited or forged is refused in one line that says why."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import bayescal as bc
from bayescal.inference.arviz_bridge import parse_netcdf, write_netcdf
from tests.helpers.spoilt import cut, edit, forge, forged, refused_in_a_line, result

FIRST = "families.models.0"
SPOILT: dict[str, tuple[Callable[[Path], object], str]] = {
    "cut draws": (
        lambda f: cut(f / "draws/pinhole-0-free.nc"),
        r"pinhole-0-free\.nc: is not what was written .* cut",
    ),
    "cut draws, forged": (
        forged("draws/pinhole-0-free.nc", cut),
        r"pinhole-0-free\.nc: .*; make it again: bayescal compare --family",
    ),
    "no draws": (
        lambda f: (f / "draws/separable-1-1-free.nc").unlink(),
        r"separable-1-1-free\.nc: there is no such file; make it again",
    ),
    "other draws, forged": (
        lambda f: [
            shutil.copy(f / "draws/pinhole-0-free.nc", f / "draws/separable-1-1-free.nc"),
            forge(f, "draws/separable-1-1-free.nc"),
        ],
        r"separable-1-1-free\.nc: holds focal_r, .*, not alpha_0",
    ),
    "edited": (
        lambda f: edit(f / "result.json", ("verdict.text", "Mine wins.")),
        r"result\.json: is not what was written there",
    ),
    "another evidence": (
        result((f"{FIRST}.log_evidence", -1.5)),
        r"the log evidence of .* is -1\.5 in the run but -3\d\d\.\d+ now: the same versions",
    ),
    "another elpd": (
        result((f"{FIRST}.elpd_loo", -1.5)),
        r"the leave-one-out elpd of .* is -1\.5 in the run",
    ),
    "another mean": (
        result((f"{FIRST}.sampling.parameters.0.mean", -1.5)),
        r"the mean of focal_r of pinhole 0, position free is -1\.5 in the run",
    ),
    "another parameter": (
        result((f"{FIRST}.sampling.parameters.0.name", "zoom")),
        r"parameters of pinhole 0, position free of the run are not .* now: focal_r",
    ),
    "not sampled": (
        result((f"{FIRST}.sampling", None)),
        r"sampling of pinhole 0, position free is nothing in the run",
    ),
    "another verdict": (
        result(("verdict.best", "separable (1, 1), position stated")),
        r"the best model is separable \(1, 1\), position stated in the run but pinhole 0",
    ),
    "a model renamed": (
        result((f"{FIRST}.name", "fisheye 1")),
        r"models of the run are not those computed now: fisheye 1",
    ),
    "other points": (
        forged("points.csv", lambda p: p.write_text(p.read_text().replace("390", "391", 1))),
        r"the (maximum of the log likelihood|log evidence|leave-one-out elpd) of .* in the run",
    ),
    "an unknown family": (
        result(("settings.families", ["fisheye"])),
        r"result\.json: family must be separable, bivariate, pinhole, not 'fisheye' .*; make it",
    ),
    "unknown powers": (
        result(("settings.radial", "odd")),
        r"result\.json: radial must be even or all, not 'odd'",
    ),
    "no pairs": (result(("settings.pairs", [[1, 2, 3]])), r"result\.json: .*; make it again"),
    "another position": (
        result(("settings.positions", ["free"])),
        r"models of the run are not those computed now: pinhole 0, position stated",
    ),
    "more orders": (
        result(("settings.radial_orders", [0, 1])),
        r"pinhole-1-stated\.nc: there is no such file",
    ),
    "a setting to come": (
        result(("settings.colour", "blue")),
        r"was made with the setting 'colour', which bayescal \S+ does not have .*; upgrade",
    ),
    "an unusable setting": (result(("settings.ess", 1)), r"ess must be from 100 to 1000000"),
    "a text for a number": (
        result(("settings.tau", "x")),
        r"is damaged: settings\.tau is missing or not what belongs there",
    ),
    "no models": (result(("families.models", [])), r"is damaged: families\.models is"),
    "no parameters": (
        result((f"{FIRST}.sampling.parameters", [])),
        r"is damaged: families\.models\.0\.sampling\.parameters is",
    ),
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_spoilt_run_is_refused_in_one_line(name: str, families_copy: Path) -> None:
    change, complaint = SPOILT[name]
    change(families_copy)
    refused_in_a_line(families_copy, complaint)


def test_rounding_is_no_disagreement(families_copy: Path) -> None:
    value = json.loads((families_copy / "result.json").read_text())["families"]["models"][0][
        "log_evidence"
    ]
    result((f"{FIRST}.log_evidence", value + 5e-7))(families_copy)
    bc.open_run(families_copy)
    result((f"{FIRST}.log_evidence", value + 5e-6))(families_copy)
    with pytest.raises(bc.InputError, match="log evidence of"):
        bc.open_run(families_copy)


def test_a_folder_without_hashes_says_so(families_copy: Path) -> None:
    """As `compare --family --out` wrote it before runs of families could be reopened."""
    (families_copy / "run.json").unlink()
    with pytest.raises(bc.InputError, match=r"holds no run\.json.*make it again"):
        bc.open_run(families_copy)


def test_draws_of_another_density_are_refused(families_copy: Path) -> None:
    """Hashes forged: the density at a few draws is not the one that was kept of them."""
    path = families_copy / "draws" / "pinhole-0-free.nc"
    draws = parse_netcdf(path.read_bytes())
    draws.groups["sample_stats"]["lp"] = draws.groups["sample_stats"]["lp"] + 0.01
    write_netcdf(path, draws)
    forge(families_copy, f"draws/{path.name}")
    with pytest.raises(bc.InputError, match=r"pinhole-0-free\.nc: the density of its draws is not"):
        bc.open_run(families_copy)
