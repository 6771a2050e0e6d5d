"""``bayescal reproduce`` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import bayescal as bc
from bayescal.cli import main
from bayescal.errors import OutputError
from bayescal.files import FolderKind, write_folder
from bayescal.report.document.shared import schema
from bayescal.reproduction.kind import REPRODUCTION
from tests.helpers.listing import MODELS, listing

FIGURES = [
    "figure-06-pixels",
    "figure-07-residuals-r",
    "figure-08-residuals-c",
    "figure-09-squared-errors-r",
    "figure-10-squared-errors-c",
]


def run(capsys, *options: str) -> tuple[int, str, str]:
    """Exit code, standard output and error of ``bayescal reproduce``."""
    try:
        code = main(["reproduce", *options])
    except SystemExit as stop:
        code = stop.code
    out, err = capsys.readouterr()
    return code, out, err


@pytest.fixture(scope="module")
def document(tmp_path_factory):
    path = tmp_path_factory.mktemp("json") / "all.json"
    assert main(["reproduce", "--json", str(path), "--quiet"]) == 0
    return json.loads(path.read_text(encoding="utf-8"))


def test_the_main_message_fits_one_screen(capsys):
    code, out, err = run(capsys)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert max(map(len, lines)) <= 100
    screen = "\n".join(lines[:20])
    table = [line.split() for line in lines[6:11]]
    assert [row[0] for row in table] == ["1", "2", "3", "4", "5"]
    assert [row[1] for row in table] == ["3074.6", "1571.3", "1023.8", "737.9", "736.7"]
    assert [row[5] for row in table] == ["3074.6", "1571.3", "1524.2", "1522.6", "1461.3"]
    assert [row[9] for row in table] == ["644.7", "626.3", "623.3", "599.1", "599.0"]
    assert "r as written: BIC is lowest at order 4; order 5 takes 0.2% more off RSS" in screen
    assert "r as coded: BIC is lowest at order 2" in screen
    assert "c: BIC is lowest at order 1; orders 2-5 take 7.1% more off RSS, chance alone 7.3%" in (
        screen
    )
    assert len(lines) < 48


@pytest.mark.parametrize(
    "options",
    [
        ["--common"],
        ["--per-point"],
        ["--per-point", "--common", "--significance", "0.2"],
        ["--sigma", "0.8"],
        ["--sigma", "0.001", "--significance", "1e-6"],
    ],
)
def test_every_view_stays_within_100_columns_and_cuts_nothing(capsys, options):
    code, out, _ = run(capsys, *options)
    assert code == 0
    assert max(map(len, out.splitlines())) <= 100
    assert "…" not in out


def test_a_large_data_set_fits_the_same_columns(capsys, tmp_path):
    """Point numbers of four digits, more points removed than a row can name."""
    rng = np.random.default_rng(0)
    x, y, z = rng.uniform([[-300], [-200], [300]], [[300], [200], [900]], (3, 2000))
    noise = 10 * rng.standard_t(3, (2000, 2))
    pixels = np.column_stack([900 + 1000 * x / z, 500 + 1000 * y / z]) + noise
    points = tmp_path / "points.csv"
    bc.save(bc.Correspondences.from_arrays(np.column_stack([x, y, z]), pixels), points)
    code, out, _ = run(capsys, str(points))
    assert code == 0
    assert max(map(len, out.splitlines())) <= 100
    assert "…" not in out
    assert " more " in out


def test_before_and_after_stand_beside_each_other_with_the_points_that_went(capsys):
    _, out, _ = run(capsys)
    rows = [" ".join(line.split()) for line in out.splitlines()]
    assert "r as written, 1 1 2 3 6 44 4 51 3074.6 310.9 7.34 2.47" in rows
    assert "r as written, 4 44 6 55 737.9 425.9 3.60 2.78" in rows
    assert "c, 1 16 19 1 54 644.7 165.3 3.36 1.75 225.6" in rows
    warning = " ".join(out.split())
    assert "warning: r as written: after elimination the orders rest on different points" in warning
    assert "5% family-wise, sigma inferred" in out


def test_common_points_replace_the_warning(capsys):
    _, out, _ = run(capsys, "--common")
    assert "warning" not in out
    assert "r as written, on these 51 points: BIC is lowest at order 1." in out


def test_the_document_follows_its_schema(document):
    known = schema("reproduction", "bayescal.reproduction")
    jsonschema.Draft202012Validator.check_schema(known)
    jsonschema.validate(document, known)
    changed = dict(document, as_coded={"r": document["as_coded"]["r"]})
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(changed, known)


@pytest.mark.parametrize(("variant", "axis", "order"), MODELS)
def test_the_document_has_every_residual_of_the_listing(document, variant, axis, order):
    entry = document[variant.replace("-", "_")][axis][order - 1]
    coefficients, residuals = listing(variant, axis, order)
    assert entry["order"] == order
    assert len(entry["residuals"]) == 57
    assert np.abs(np.array(entry["residuals"]) - residuals).max() < 1e-9
    assert entry["coefficients"] == pytest.approx(coefficients.tolist(), rel=1e-9)
    assert entry["rss"] == pytest.approx(float(residuals @ residuals), rel=1e-10)
    assert len(entry["monomials"]) == len(entry["names"]) == order + 1


def test_the_document_tells_points_by_number_and_what_went(document):
    entry = document["as_written"]["r"][3]
    assert [step["point"] for step in entry["elimination"]["steps"]] == [44, 6]
    assert sorted([44, 6, *entry["elimination"]["kept"]]) == list(range(1, 58))
    assert entry["elimination"]["after"]["n"] == 55
    assert entry["common"] is None
    assert document["after_elimination"]["as_written"]["r"]["orders_on_same_points"] is False
    assert document["rule"] == {
        "significance": 0.05,
        "kind": "family-wise",
        "sigma": "inferred",
        "sigma_px": None,
        "common": False,
    }
    assert len(document["warnings"]) == 2
    assert document["data"]["n_points"] == 57


def test_what_can_not_be_had_is_null(capsys):
    code, out, _ = run(capsys, "--per-point", "--common", "--json", "-")
    found = json.loads(out)  # and nothing but the document is printed
    jsonschema.validate(found, schema("reproduction", "bayescal.reproduction"))
    last = found["as_written"]["c"][4]
    assert (code, last["elimination"]["after"]["bic"], last["common"]) == (0, None, None)
    assert found["after_elimination"]["as_written"]["c"]["lowest_bic_on_common"] is None


def test_points_of_ones_own_go_through_the_same_procedure(capsys, tmp_path):
    points = tmp_path / "points.csv"
    bc.save(bc.thesis(), points)
    camera = ["--camera-position", "330", "57", "0", "--image-height", "1080", "--c-from-bottom"]
    code, out, _ = run(capsys, str(points), *camera, "--json", "-")
    assert code == 0
    assert [round(entry["rss"], 1) for entry in json.loads(out)["as_coded"]["r"]] == [
        3074.6,
        1571.3,
        1524.2,
        1522.6,
        1461.3,
    ]


def test_out_is_a_folder_with_the_document_and_every_figure(capsys, tmp_path):
    folder = tmp_path / "run"
    code, out, err = run(capsys, "--out", str(folder), "--quiet")
    assert (code, out, err) == (0, "", "")
    stems = FIGURES + [f"{name}-standardised" for name in FIGURES[1:]]
    wanted = {f"{stem}.{kind}" for stem in stems for kind in ("png", "svg")} | {"reproduction.json"}
    assert {path.name for path in folder.iterdir()} == wanted
    assert all(path.stat().st_size > 1000 for path in folder.iterdir())
    jsonschema.validate(
        json.loads((folder / "reproduction.json").read_text(encoding="utf-8")),
        schema("reproduction", "bayescal.reproduction"),
    )
    assert [path.name for path in tmp_path.iterdir()] == ["run"]  # nothing beside it

    # An earlier one is left alone, and replaced with --force only.
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    code, _, err = run(capsys, "--out", str(folder))
    assert (code, len(err.splitlines())) == (2, 1)
    assert "holds an earlier reproduction" in err
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    other = bc.reproduce(bc.thesis(), orders=[1])
    with pytest.raises(OSError, match="--force"):
        REPRODUCTION.write(folder, other, "{}", force=False)
    REPRODUCTION.write(folder, other, "{}", force=True)
    assert (folder / "reproduction.json").read_text() == "{}"
    assert {path.name for path in folder.iterdir()} == wanted
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_folder_that_fails_half_way_leaves_the_earlier_one(tmp_path):
    def fill(folder: Path) -> None:
        (folder / "marker").write_text("new")
        raise OSError("the disk is full")

    earlier = tmp_path / "run"
    earlier.mkdir()
    (earlier / "marker").write_text("old")
    with pytest.raises(OutputError, match="the disk is full"):
        write_folder(earlier, FolderKind("run", "marker", ()), fill, force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert (earlier / "marker").read_text() == "old"


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--significance", "2"], "between 0 and 1"),
        (["--significance", "x"], "invalid float value"),
        (["--sigma", "replicates"], "is neither inferred nor a number of px"),
        (["--sigma", "-1"], "positive number of px"),
        (["--orders", "1-3"], "unrecognized arguments"),
        (["absent.csv"], "no such file"),
    ],
)
def test_bad_usage_gets_one_line_and_code_2(capsys, options, complaint):
    code, out, err = run(capsys, *options)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert complaint in err


def test_a_folder_that_is_no_reproduction_is_never_replaced(capsys, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "result.json").write_text("{}")
    code, _, err = run(capsys, "--out", str(tmp_path / "mine"), "--force")
    assert code == 2
    assert "is not a reproduction" in err
    assert (tmp_path / "mine" / "result.json").read_text() == "{}"


def test_output_that_can_not_be_written_is_refused_before_anything_is_written(capsys, tmp_path):
    there = tmp_path / "there.json"
    there.write_text("mine")
    code, out, err = run(capsys, "--json", str(there), "--out", str(tmp_path / "run"))
    assert (code, out) == (2, "")
    assert "exists" in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there.json"]
    code, _, err = run(capsys, "--out", str(tmp_path / "no" / "folder"))
    assert (code, "there is no folder" in err) == (2, True)


def test_help_names_every_option(capsys):
    code, out, _ = run(capsys, "--help")
    assert code == 0
    for option in ("--out", "--json", "--significance", "--per-point", "--common", "--sigma",
                   "--force", "--quiet"):  # fmt: skip
        assert option in out
