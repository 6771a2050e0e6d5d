"""compare --family, --position and fit --family: what they print, write and refuse."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.report.document.shared import schema
from tests.helpers.command import here


def run(capsys, *arguments):
    code = main([*arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_compare_across_families(capsys, tmp_path):
    folder = tmp_path / "run"
    code, out, err = run(
        capsys, "compare", "--family", "separable,pinhole", "--orders", "1", "--position",
        "stated,free", "--radial-orders", "0", "--ess", "200", "--out", str(folder),
    )  # fmt: skip
    assert code == 0
    assert err == ""
    assert max(len(line) for line in out.splitlines()) <= 100
    assert "Verdict across families: " in out
    assert "Summed over families and orders, a free camera position has" in " ".join(out.split())
    document = json.loads((folder / "result.json").read_text())
    jsonschema.validate(document, schema("families"))
    models = document["families"]["models"]
    assert len(models) == 4
    assert sum(m["probability"] for m in models) == pytest.approx(1)
    assert document["verdict"]["best"] == models[0]["name"]
    written = sorted(path.name for path in (folder / "draws").iterdir())
    assert written == ["pinhole-0-free.nc", "pinhole-0-stated.nc", "separable-1-1-free.nc"]
    code, _, err = run(capsys, "compare", "--family", "pinhole", "--out", str(folder))
    assert code == 2
    assert "--force" in err


def test_fit_a_pinhole(capsys):
    code, out, _ = run(capsys, "fit", "--family", "pinhole", "--order", "1", "--ess", "200")
    assert code == 0
    assert max(len(line) for line in out.splitlines()) <= 100
    for words in ("focal_r", "centre_c", "rotation_x", "position_z", "k_1", "correlation"):
        assert words in out
    assert "Weakly identified together: " in out
    assert "rotation_x (+" in out


def test_the_same_seed_gives_the_same_bytes(capsys):
    arguments = ("fit", "--family", "pinhole", "--order", "0", "--ess", "200", "--json", "-")
    first, second = (json.loads(run(capsys, *arguments)[1]) for _ in range(2))
    for document in (first, second):
        del document["provenance"]["created"]
    assert first == second


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (["compare", "--family", "pinhole", "--axis", "r"], "drop --axis r"),
        (["compare", "--family", "pinhole", "--no-c-from-bottom"], "mirrored world"),
        (["compare", "--family", "bivariate", "--orders", "10"], "the highest order that works"),
        (["compare", "--family", "pinhole", "--tau", "0"], "tau must be from 1e-09"),
        (["compare", "--family", "pinhole", "--sigma", "2e-6"], "check their unit"),
        (["fit", "--family", "pinhole"], "give --order of the pinhole family"),
        (["fit", "--position", "free", "--order-r", "4"], "give --order-r and --order-c"),
        (["fit", "--family", "pinhole", "--order", "-1"], "order -1 is out of range"),
    ],
)
def test_bad_requests(capsys, arguments, match):
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (2, "")
    assert match in err
    assert err.count("\n") == 1


def test_the_setup_states_pose_and_optics(capsys, tmp_path):
    setup = tmp_path / "setup.toml"
    known = (
        "[camera]\nposition = [330, 57, 0]\nposition_sd = [1, 1, 20]\n\n"
        "[image]\nwidth = 1920\nheight = 1080\nc_from_bottom = true\n\n"
        "[prior.pinhole]\nfocal = 1100\nfocal_log_sd = 0.1\n"
    )
    setup.write_text(known)
    arguments = (
        "fit",
        "--family",
        "pinhole",
        "--order",
        "0",
        "--ess",
        "200",
        "--setup",
        str(setup),
    )
    code, out, _ = run(capsys, *arguments)
    assert code == 0
    assert "ln 1100, 0.1" in out
    assert "z ~ N(0, 20²) world units (sd as stated)" in " ".join(out.split())
    for wrong, match in (
        (known.replace("focal =", "focus ="), "setup.toml:11: prior.pinhole.focus: unknown key"),
        (known.replace("= 1100", "= -1"), "setup.toml:11: focal must be positive and finite"),
        (known.replace("[1, 1, 20]", "[1, 1]"), "setup.toml:3: camera.position_sd: must have 3"),
        (known.replace("= 1100", '= "long"'), "setup.toml:11: prior.pinhole.focal: must be a"),
    ):
        setup.write_text(wrong)
        code, out, err = run(capsys, *arguments)
        assert (code, out) == (2, "")
        assert match in err


def parameter_rows(out: str) -> list[list[str]]:
    """Words of the rows that state a parameter in px."""
    rows = [line.split() for line in out.splitlines() if " to " in line]
    return [row for row in rows if row[1] == "px"]


def test_a_fit_at_the_stated_position_prints_what_the_axes_say(capsys):
    """Order 1 of the separable family: each row as `fit` has it, which samples it with emcee."""
    orders = ("--order-r", "1", "--order-c", "1")
    code, out, _ = run(capsys, "fit", "--family", "separable", "--position", "stated", *orders)
    assert code == 0
    fit = bc.fit(bc.thesis(), 1, 1)
    rows = {row[0]: row for row in parameter_rows(out)}
    for axis, result in fit.axes.items():
        for p in result.chosen.posterior.parameters:
            name = p.name if "_" in p.name else f"{p.name}_{axis}"
            _, unit, mean, sd, *_, low, _, high = rows.pop(name)
            assert unit == "px"
            half = 0.5 * 10 ** -len(sd.partition(".")[2])  # the last digit shown
            error = 4 * p.sd / p.ess_tail**0.5
            assert float(mean) == pytest.approx(p.mean, abs=error + half)
            assert float(sd) == pytest.approx(p.sd, abs=error + half)
            # A quantile's error at 2.5 %: sqrt(q (1 - q)) / density, 2.7 sd of a normal.
            shown = float(low), float(high)
            assert shown == pytest.approx(p.interval, abs=3.5 * error + half)
    assert not rows


def test_a_bivariate_fit_prints_its_coefficients(capsys):
    """At order 1 there are three on each axis, and which power is whose is said."""
    code, out, _ = run(capsys, "fit", "--family", "bivariate", "--order", "1")
    assert code == 0
    names = [row[0] for row in parameter_rows(out)]
    coefficients = [f"{s}_{p}" for s in ("alpha", "beta") for p in ("00", "10", "01")]
    assert names == [*coefficients[:3], "sigma_r", *coefficients[3:], "sigma_c"]
    assert "First power: of x/z in r (alpha), of y/z in c (beta)" in out
    assert " (closed form); elpd " in out  # its error is of rounding alone


def test_what_a_fit_prints_stands_in_its_document(tmp_path: Path) -> None:
    """Coefficients at the stated position, closed form: each row's digits are the JSON's."""
    made = tmp_path / "made.json"
    orders = ("--order-r", "2", "--order-c", "1")
    done = here("fit", "--family", "separable", *orders, "--json", made)
    assert (done.code, done.err) == (0, "")
    document: dict[str, Any] = json.loads(made.read_text(encoding="utf-8"))
    jsonschema.validate(document, schema("families"))
    (model,) = document["families"]["models"]
    assert model["elpd_reliable"] is True
    lines = [line for line in done.out.splitlines() if " to " in line and line[1] != " "]
    rows = [line.split() for line in lines]
    printed = {row[0]: row for row in rows}
    assert list(printed) == [p["name"] for p in model["closed_form"]]
    for p in model["closed_form"]:
        assert p["axis"] == ("c" if p["name"].startswith("beta") else p["name"][-1]) or (
            p["axis"] == "r" and p["name"].startswith("alpha")
        )
        mean, sd, *_, low, _, high = (
            word for word in printed[p["name"]][1:] if word[-1].isdigit() or word == "to"
        )
        said = (p["mean"], p["sd"], *p["interval"])
        for shown, value in zip((mean, sd, low, high), said, strict=True):
            digits = len(shown.partition(".")[2])
            assert float(shown) == pytest.approx(value, abs=0.5000001 * 10**-digits)
