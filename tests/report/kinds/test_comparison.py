"""A run reopens as the comparison it was written from, or says exactly why not."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import emcee
import numpy as np
import pytest

import bayescal as bc
from bayescal.commands.shared.options import is_run
from bayescal.comparison.criteria import psis
from bayescal.comparison.results import Comparison
from bayescal.inference.arviz_bridge import parse_netcdf
from bayescal.points.setup import StatedPrior
from bayescal.report.document.comparison import comparison_document
from bayescal.report.document.shared import dumps

rng = np.random.default_rng(5)
WORLD = np.column_stack([rng.uniform(-40, 40, (16, 2)), np.repeat([60.0, 80.0, 90.0, 95.0], 4)])
PIXELS = 500 + 400 * WORLD[:, :2] / WORLD[:, 2:] + rng.normal(0, 1, (16, 2))
LABELS = ('<script>alert("1")</script>', "# a", "é\u2028", "=1+1", *map(str, range(12)))
INTEGERS = bc.Setup((1, -2, 0), 1000, 900, c_from_bottom=True, assumed=("width",))
STATED = {a: StatedPrior((500, 0, 0), (500, 400, 7)) for a in ("r", "c")}


def points(**more: Any) -> bc.Correspondences:
    return bc.Correspondences.from_arrays(WORLD, PIXELS, **more)


def text(comparison: Comparison) -> str:
    return dumps(comparison_document(comparison, "a command"))


def test_the_document_of_a_reopened_run_is_the_run_s_to_the_byte(run: Path) -> None:
    assert text(bc.open_run(run)) == (run / "result.json").read_text(encoding="utf-8")


def test_everything_in_memory_is_what_was_computed(run: Path) -> None:
    computed = bc.compare(bc.thesis(), [1, 2])
    found = bc.open_run(run)
    for name, axis in computed.axes.items():
        for one, other in zip(axis.orders, found.axes[name].orders, strict=True):
            first, second = one.posterior.chain, other.posterior.chain
            for field in ("draws", "theta", "log_prob"):
                assert getattr(first, field).tobytes() == getattr(second, field).tobytes()
            assert first.diagnostics == second.diagnostics
            assert one.posterior.parameters == other.posterior.parameters
        assert axis.verdict == found.axes[name].verdict
    assert found.settings == computed.settings
    points = bc.thesis()
    for field in dataclasses.fields(points):
        one, other = getattr(points, field.name), getattr(found.points, field.name)
        assert np.array_equal(one, other) if isinstance(one, np.ndarray) else one == other


def test_a_defence_comes_back_may_be_left_out_and_may_be_added(tmp_path: Path) -> None:
    asked: dict[str, Any] = {"orders": [1], "axis": "c", "ess": 100}
    computed = bc.compare(points(), **asked, defend=True)
    bc.save_run(computed, tmp_path / "defended")
    bc.save_run(bc.compare(points(), **asked), tmp_path / "plain")
    kept = (tmp_path / "defended" / "result.json").read_text(encoding="utf-8")
    assert text(bc.open_run(tmp_path / "defended")) == kept
    without = bc.open_run(tmp_path / "defended", defend=False)
    assert without.axes["c"].defence is None
    assert without.origin is None  # no longer what the run holds
    added = bc.open_run(tmp_path / "plain", defend=True)
    assert added.axes["c"].defence is not None
    found = comparison_document(added, "")
    assert found["axes"] == json.loads(kept)["axes"]


def test_a_defence_without_a_closed_form_is_not_sampled_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor orders beyond the range, other noise, points left out."""
    asked: dict[str, Any] = {"noise": "student-t", "defend": True, "ess": 100}
    bc.save_run(bc.compare(points(), [1], axis="c", **asked), tmp_path / "run")

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("something was computed")

    monkeypatch.setattr(emcee.EnsembleSampler, "run_mcmc", refuse)
    monkeypatch.setattr(psis, "psis_loo", refuse)
    found = bc.open_run(tmp_path / "run")
    assert found.axes["c"].defence.beyond.orders == (2, 3, 4)
    assert text(found) == (tmp_path / "run" / "result.json").read_text(encoding="utf-8")
    monkeypatch.undo()
    monkeypatch.setattr(psis, "psis_loo", refuse)
    with pytest.raises(AssertionError, match="something was computed"):  # negative control
        bc.compare(points(), [1], axis="c", **asked)


VARIANTS: dict[str, Callable[[], Comparison]] = {
    "labels, groups and deviations": lambda: bc.compare(
        points(labels=LABELS, groups=tuple("abcd" * 4), sigma_r=[0.1 + 0.2] * 16, setup=INTEGERS),
        [1, 2],
        ess=100,
    ),
    "a scale, world errors": lambda: bc.compare(
        points(
            sigma_r=[1.0] * 16,
            sigma_c=[2.0] * 16,
            sigma_x=[0.0] * 15 + [0.1],
            setup=dataclasses.replace(INTEGERS, world_sigma=(0, 0.01, 0)),
        ),
        [1],
        sigma="scale",
        ess=100,
    ),
    "stated priors": lambda: bc.compare(points(setup=bc.Setup(priors=STATED)), [1, 2], ess=100),
    "flat": lambda: bc.compare(points(), [1, 3], axis="c", prior="flat", ess=100),
    "known, numpy's numbers": lambda: bc.compare(
        points(),
        [2],
        sigma=np.int64(1),
        tau=np.float32(0.25),
        seed=np.uint8(7),
        ess=np.int16(100),
    ),
    "one axis's order": lambda: bc.fit(bc.thesis(), order_c=1, ess=100, seed=2**70),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_every_kind_of_comparison_comes_back(name: str, tmp_path: Path) -> None:
    comparison = VARIANTS[name]()
    bc.save_run(comparison, tmp_path / "run")
    kept = (tmp_path / "run" / "result.json").read_text(encoding="utf-8")
    assert text(bc.open_run(tmp_path / "run")) == kept
    made, stored = (json.loads(t) for t in (text(comparison), kept))
    for found in (made, stored):
        del found["provenance"]
    assert made == stored


def test_nothing_is_sampled(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("emcee was called")

    monkeypatch.setattr(emcee.EnsembleSampler, "run_mcmc", refuse)
    bc.open_run(run)
    with pytest.raises(AssertionError, match="emcee was called"):  # negative control
        bc.compare(bc.thesis(), [1])


def test_draws_open_in_arviz_with_groups_dimensions_and_attributes(run: Path) -> None:
    import arviz

    raw = (run / "draws" / "r-order-2.nc").read_bytes()
    ours = parse_netcdf(raw)
    tree = arviz.from_netcdf(run / "draws" / "r-order-2.nc")
    names = ["alpha_0", "alpha_1", "alpha_2", "sigma", "tau"]
    for group, dims in {
        "posterior": dict.fromkeys(names, ("chain", "draw")),
        "unconstrained_posterior": {"theta": ("chain", "draw", "coordinate")},
        "sample_stats": {"lp": ("chain", "draw")},
        "observed_data": {"pixel": ("point",), "regressor": ("point",)},
    }.items():
        assert {str(k): v.dims for k, v in tree[group].data_vars.items()} == dims
        for name in dims:
            assert tree[group][name].to_numpy().tobytes() == ours.groups[group][name].tobytes()
    attributes = tree["posterior"].attrs
    assert (attributes["axis"], attributes["regressor"], attributes["order"]) == ("r", "x/z", 2)
    assert "px" in attributes["units"]
    assert ours.values == json.loads(tree.attrs["bayescal"])
    assert ours.values["names"] == names
    tree.close()


def test_a_comparison_of_arrays_is_no_run(tmp_path: Path) -> None:
    comparison = bc.compare_polynomials(range(9), np.arange(9.0) ** 2 % 7, [1], ess=100)
    with pytest.raises(bc.InputError, match="of plain arrays"):
        bc.save_run(comparison, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_points_and_runs_are_told_apart(run: Path, tmp_path: Path) -> None:
    def asked(place: Path | str | None) -> bool:
        return is_run(argparse.Namespace(points=None if place is None else str(place)), ())

    assert asked(run)
    assert not any(map(asked, (None, "-", run / "points.csv", tmp_path / "none.csv", "n" * 300)))
    with pytest.raises(bc.InputError, match=r"is a folder, but not a run: it holds no result\.js"):
        asked(tmp_path)
