"""The command: what it prints and writes, and how it ends."""

from __future__ import annotations

import argparse
import dataclasses
import json
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import bayescal as bc
from bayescal.cli import COMMANDS
from bayescal.commands.shared.output import deliver
from bayescal.comparison.results import Comparison
from tests.helpers.command import apart, environment, here
from tests.helpers.points_files import rows, text, write

SHORT = ("--orders", "1-2", "--ess", "100")
PNG = b"\x89PNG\r\n\x1a\n"
# Options that the design names for the command, beside whatever else there is.
COMPARE = "--orders --axis --sigma --prior --tau --setup --seed --ess --json --out --quiet --force"
FIT = COMPARE.replace("--orders --axis", "--order-r --order-c")


def without_time(document: str) -> str:
    changed, count = re.subn(r'"created": "[^"]*"', '"created": null', document)
    assert count == 1
    return changed


def test_prints_tables_of_both_axes_and_nothing_else(tmp_path: Path) -> None:
    done = here("compare", write(tmp_path, text(rows())), *SHORT)
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith("12 points from ")
    for piece in ("r as a polynomial of x/z", "c as a polynomial of y/z", "Verdict on r: Order"):
        assert piece in done.out


def test_axis_limits_what_is_compared() -> None:
    done = here("compare", "--axis", "c", *SHORT)
    assert "c as a polynomial" in done.out
    assert "r as a polynomial" not in done.out


def test_fit_prints_one_model_in_full() -> None:
    done = here("fit", "--order-r", "4", "--ess", "100")
    assert (done.code, done.err) == (0, "")
    for piece in (
        r"order: +4 \(5 coefficients, K = 6\)",
        r"residual sum of squares: +737\.934 px",
        r"AIC, AICc, BIC: +319\.7\d\d, 321\.4\d\d, 331\.98\d",
        r"ln evidence: +-182\.00",
        r"alpha_4 .*\b203\b",  # least squares
        r"alpha_4 .*\b(19|20)\d +46 ",  # mean and sd of the draws
        r"sigma +3\.8",
        r"tau / size ",
        r"exact mean",
    ):
        assert re.search(piece, done.out), piece
    assert "c as a polynomial" not in done.out


def test_json_to_a_file_and_to_standard_output_is_the_same(tmp_path: Path) -> None:
    points = write(tmp_path, text(rows()))
    path = tmp_path / "result.json"
    filed = here("compare", points, *SHORT, "--json", path)
    assert filed.code == 0
    assert "Verdict on r" in filed.out  # tables as well
    printed = here("compare", points, *SHORT, "--json", "-")
    assert printed.code == 0
    found = json.loads(printed.out)  # and nothing else
    kept = json.loads(path.read_text(encoding="utf-8"))
    for document in (found, kept):
        del document["provenance"]["created"]
        assert document["provenance"].pop("command").startswith("bayescal compare")
    assert found == kept


def test_same_seed_gives_the_same_bytes_and_another_seed_others(tmp_path: Path) -> None:
    points = write(tmp_path, text(rows()))
    seeded = ("compare", points, *SHORT, "--json", "-", "--seed")
    one, again, other = (here(*seeded, seed).out for seed in ("7", "7", "8"))
    assert without_time(one) == without_time(again)
    apart_again = apart(*seeded, "7", folder=tmp_path, OMP_NUM_THREADS="2").stdout.decode()
    assert without_time(one) == without_time(apart_again)
    means = [
        [c["mean"] for c in json.loads(out)["axes"]["r"]["orders"][0]["coefficients"]]
        for out in (one, other)
    ]
    assert means[0] != means[1]


def test_seed_may_be_larger_than_any_machine_word() -> None:
    done = here("compare", "--axis", "r", *SHORT, "--json", "-", "--seed", str(2**70))
    assert json.loads(done.out)["provenance"]["seed"] == 2**70


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "run"
    done = here("compare", *SHORT, "--out", folder, "--quiet")
    assert (done.code, done.out, done.err) == (0, "", "")
    return folder


def test_run_holds_the_document(run_folder: Path) -> None:
    document = json.loads((run_folder / "result.json").read_text(encoding="utf-8"))
    assert document["data"]["source"] == "thesis"
    assert [o["order"] for o in document["axes"]["c"]["orders"]] == [1, 2]
    assert [p.name for p in run_folder.parent.iterdir()] == ["run"]  # no leftovers


def test_run_holds_draws_that_arviz_opens(run_folder: Path) -> None:
    import arviz

    document = json.loads((run_folder / "result.json").read_text(encoding="utf-8"))
    for axis in ("r", "c"):
        for order in document["axes"][axis]["orders"]:
            tree = arviz.from_netcdf(run_folder / "draws" / f"{axis}-order-{order['order']}.nc")
            posterior = tree["posterior"]
            assert posterior.sizes["chain"] == order["sampling"]["walkers"]
            assert posterior.sizes["draw"] == order["sampling"]["steps"]
            for summary in order["coefficients"]:
                values = posterior[summary["name"]].to_numpy()
                assert np.mean(values) == pytest.approx(summary["mean"], rel=1e-12)
            assert tree["sample_stats"]["lp"].shape == values.shape
            assert tree["observed_data"]["pixel"].size == 57
            tree.close()


def test_run_holds_real_pictures(run_folder: Path) -> None:
    from matplotlib.image import imread

    pictures = sorted(run_folder.glob("*.png"))
    assert [p.name for p in pictures] == ["corner-c.png", "corner-r.png"]
    for path in pictures:
        assert path.read_bytes().startswith(PNG)
        pixels = imread(path)
        assert min(pixels.shape[:2]) > 300
        assert pixels.std() > 0.01  # not blank


def test_force_replaces_an_earlier_run_and_file(tmp_path: Path) -> None:
    folder, path = tmp_path / "run", tmp_path / "result.json"
    wanted = ("compare", "--ess", "100", "--axis", "c", "--out", folder, "--json", path, "--quiet")
    assert here(*wanted, "--orders", "1").code == 0
    first = path.read_bytes()
    assert here(*wanted, "--orders", "2").code == 2
    assert path.read_bytes() == first
    assert here(*wanted, "--orders", "2", "--force").code == 0
    assert [p.name for p in (folder / "draws").iterdir()] == ["c-order-2.nc"]
    assert path.read_bytes() == (folder / "result.json").read_bytes() != first
    assert {p.name for p in tmp_path.iterdir()} == {"run", "result.json"}


def test_quiet_prints_nothing() -> None:
    assert here("compare", *SHORT, "--quiet") == (0, "", "")


@pytest.mark.parametrize("fault", ["not converged", "at odds with the closed form"])
def test_draws_that_can_not_be_trusted_end_with_3_and_print_all_the_same(
    fault: str, thesis_comparison: Comparison, capsys: pytest.CaptureFixture[str]
) -> None:
    result = thesis_comparison.axes["r"].orders[0]
    posterior = result.posterior
    if fault == "not converged":
        posterior = dataclasses.replace(
            posterior, chain=dataclasses.replace(posterior.chain, converged=False)
        )
    else:
        far = dataclasses.replace(posterior.parameters[0], deviation=5.1)
        posterior = dataclasses.replace(posterior, parameters=(far, *posterior.parameters[1:]))
    axis = thesis_comparison.axes["r"]
    orders = (dataclasses.replace(result, posterior=posterior), *axis.orders[1:])
    axes = {**thesis_comparison.axes, "r": dataclasses.replace(axis, orders=orders)}
    unsound = dataclasses.replace(thesis_comparison, axes=axes)
    assert thesis_comparison.sound
    assert not unsound.sound
    options = argparse.Namespace(json=None, out=None, force=False, quiet=False)
    assert deliver(options, thesis_comparison) == 0
    sound_out, sound_err = capsys.readouterr()
    assert sound_err == ""
    assert "NOT SOUND" not in sound_out
    assert deliver(options, unsound) == 3
    out, err = capsys.readouterr()
    assert "NOT SOUND" in out
    assert "Verdict on c" in out
    assert err.count("\n") == 1


def test_version() -> None:
    assert here("--version") == (0, f"bayescal {bc.__version__}\n", "")


def test_help_lists_every_command() -> None:
    done = here("--help")
    assert done.code == 0
    assert {"compare", "fit"} <= set(COMMANDS)
    for name in COMMANDS:
        assert re.search(rf"^ +{name}\s+\S", done.out, re.MULTILINE)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command_explains_every_option(name: str) -> None:
    done = here(name, "--help")
    assert (done.code, done.err) == (0, "")
    parser = argparse.ArgumentParser(prog=name)
    import_module(f"bayescal.commands.{name}").add_arguments(parser)
    declared = {option: a.help for a in parser._actions for option in a.option_strings}
    for option in {"compare": COMPARE, "fit": FIT}.get(name, "").split():
        assert option in declared
    for option, explained in declared.items():
        assert re.search(rf"^ +(.*, )?{re.escape(option)}\b", done.out, re.MULTILINE), option
        assert explained


def test_help_and_refusals_import_nothing_heavy(tmp_path: Path) -> None:
    script = f"""
import contextlib, io, sys
from bayescal.cli import main
for arguments in (["--version"], ["--help"], *([name, "--help"] for name in {list(COMMANDS)!r}),
                  ["compare", "--orders", "5-1"], ["frobnicate"]):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        try:
            main(arguments)
        except SystemExit:
            pass
heavy = ["numpy", "scipy", "emcee", "arviz", "arviz_base", "arviz_stats", "pandas", "xarray",
         "matplotlib", "corner", "rich", "tqdm", "h5py"]
print([name for name in heavy if name in sys.modules])
"""
    found = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path, env=environment(), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert found.stdout == "[]\n"


def test_a_plain_comparison_imports_only_what_it_needs(tmp_path: Path) -> None:
    script = """
import sys
from importlib.util import find_spec
from bayescal.cli import main
main(["compare", "--orders", "1", "--axis", "c", "--ess", "100", "--quiet"])
wide = ["scipy.stats", "h5py", "pandas", "matplotlib", "xarray"]
spared = ["comparison.defence.defence", "comparison.criteria.leave_one_out",
          "comparison.criteria.psis",
          "density.robust_linear", "inference.sampled_posterior", "report.document",
          "comparison.families.analysis", "comparison.outliers"]
loaded = [name for name in spared if f"bayescal.{name}" in sys.modules]
print(loaded, [name for name in spared if find_spec(f"bayescal.{name}") is None])
print([name for name in wide if name in sys.modules])
"""
    found = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path, env=environment(), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert found.stdout == "[] []\n[]\n"  # the second: no name is out of date
