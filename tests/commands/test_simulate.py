"""``bayescal simulate``: a file with its truth, and the command that compares it."""

from __future__ import annotations

import json
import re
import shlex

import pytest

from bayescal.cli import main
from bayescal.points.reader import load


def command(*words: object) -> int:
    """Exit code, also where argparse ends the process."""
    try:
        return main(["simulate", *map(str, words)])
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 1


def test_the_printed_command_finds_the_truth(tmp_path, capsys):
    """Truth: order 2 of r, 200 px of it at the edge over 0.1 px of noise; c is a line."""
    place = tmp_path / "sim one.csv"
    words = ["--alpha", 900, -1200, 550, "--beta", 500, "1.2e3", "--sigma", 0.1, "--n", 40]
    assert command(*words, "--like", "--out", place) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == f"40 points in {place}"
    program, *compare = shlex.split(printed[-1])
    assert program == "bayescal"
    assert main([*compare, "--orders", "1-2", "--ess", "400", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["axes"]["r"]["verdict"]["order"] == 2
    assert found["axes"]["c"]["verdict"]["order"] == 1
    text = place.read_text()
    assert printed[2].endswith(": 900, -1200, 550")  # the digits that people read; the file has all
    assert f"# compare with: {printed[-1]}\n" in text
    assert re.search(r"^#   alpha, px, .*: 900\.0, -1200\.0, 550\.0$", text, re.MULTILINE)


def test_standard_output_is_the_file(tmp_path, capsys):
    words = ["--order", 3, "--order-c", 1, "--n", 12, "--seed", 5]
    assert command(*words, "--out", tmp_path / "sim.csv") == 0
    capsys.readouterr()
    assert command(*words) == 0
    printed = capsys.readouterr().out
    (tmp_path / "printed.csv").write_text(printed)
    written, shown = load(tmp_path / "sim.csv"), load(tmp_path / "printed.csv")
    assert written.pixels.tolist() == shown.pixels.tolist()
    comments = [line for line in printed.splitlines() if line.startswith("#")]
    assert "# truth of r: order 3, sigma 1 px, tau 0.02" in comments
    assert "# truth of c: order 1, sigma 1 px" in comments
    assert comments[-1].endswith(
        "compare FILE.csv --camera-position 0 0 0 --image-width 1920 --image-height 1080 "
        "--c-from-bottom"
    )


def test_a_setup_file_is_the_one_to_compare_with(tmp_path, capsys):
    setup = tmp_path / "camera.toml"
    setup.write_text("[camera]\nposition = [1, 2, 3]\n[image]\nwidth = 640\nheight = 480\n")
    assert command("--order", 2, "--setup", setup) == 0
    assert f"compare FILE.csv --setup {setup}\n" in capsys.readouterr().out


def test_a_file_is_replaced_only_when_asked(tmp_path, capsys):
    place = tmp_path / "sim.csv"
    place.write_text("mine")
    assert command("--order", 2, "--out", place) == 2
    assert place.read_text() == "mine"
    assert "exists; choose another name or add --force" in capsys.readouterr().err
    assert command("--order", 2, "--out", place, "--force") == 0
    assert len(load(place)) == 57


def test_no_name_breaks_out_of_its_comment(tmp_path):
    """A name that holds a line break: the comments stay comments."""
    place = tmp_path / "sim\n1,2,3,4,5.csv"
    assert command("--order", 2, "--n", 9, "--out", place) == 0
    assert len(load(place)) == 9


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "the order of r is not given; give --order K"),
        (["--order-r", 2], "the order of c is not given"),
        (["--order", 0], "order 0 is out of range"),
        (["--order", "two"], "invalid int value: 'two'"),
        (["--order", 3, "--n", 3], "order 3 has 4 coefficients for 3 points"),
        (["--order", 3, "--n", 10**9], "number of points must be from 2 to 1000000"),
        (["--order", 3, "--sigma", -1], "sigma must be from 0"),
        (["--order", 3, "--tau", "nan"], "tau must be a positive number"),
        (["--order", 3, "--seed", -1], "seed must not be negative"),
        (["--order", 3, "--like", "nowhere.csv"], "nowhere.csv: there is no such file"),
        (["--order", 3, "--setup", "nowhere.toml"], "nowhere.toml: there is no such file"),
        (["--order", 3, "--alpha", "x"], "invalid float value: 'x'"),
        (["--order", 3, "--order-r", 2, "--alpha", 1, 2], "2 coefficients, which is order 1"),
    ],
)
def test_bad_options_get_one_line(words, complaint, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert command(*words, "--out", "sim.csv") == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert complaint in printed.err
    assert printed.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
