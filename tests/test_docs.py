"""What README and docs show is what happens: commands, Python, setup, printed output."""

import os
import re
import shlex
import shutil
from pathlib import Path

import pytest

import bayescal as bc
from bayescal.cli import COMMANDS, main
from bayescal.points.bundled import data_folder

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
RUNS = ("bayescal ", "./scripts/run ")
FIRST = "./scripts/run compare --orders 1-5"  # its table is shown too


def blocks(page, language):
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def shown_commands():
    for page in PAGES:
        for block in blocks(page, "console"):
            for line in block.splitlines():
                if line.startswith("$ "):
                    yield pytest.param(line[2:], id=f"{page.name}: {line[2:]}")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files that the pages name, made of the bundled data."""
    shutil.copy(data_folder() / "thesis" / "points.csv", tmp_path / "points.csv")
    shutil.copy(data_folder() / "thesis" / "setup.toml", tmp_path / "setup.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("command", list(shown_commands()))
def test_shown_commands_work(command, capsys):
    if command.startswith(RUNS):
        if "sim.csv" in command and "simulate" not in command:
            assert main(["simulate", "--order", "3", "--sigma", "1", "--out", "sim.csv"]) == 0
        words = shlex.split(command)[1:]
        if "run" in words and "--out run" not in command:
            assert main(["compare", "--orders", "1,4", "--ess", "400", "--out", "run"]) == 0
        assert main(words) == 0
        printed = capsys.readouterr()
        assert printed.err == ""
        if command == FIRST:
            shown = next(b for b in blocks(ROOT / "README.md", "text") if "ln Z" in b)
            assert not set(shown.splitlines()) - set(printed.out.splitlines())
    else:
        script = ROOT / shlex.split(command)[0]
        assert os.access(script, os.X_OK)


def test_pages_show_the_main_job():
    commands = [p.values[0] for p in shown_commands()]
    assert FIRST in commands
    assert "./scripts/test" in commands


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_shown_python_runs(page, capsys):
    for block in blocks(page, "python"):
        exec(compile(block, str(page), "exec"), {})
    capsys.readouterr()


def test_shown_setup_is_the_bundled_one(folder):
    (shown,) = blocks(ROOT / "README.md", "toml")
    (folder / "shown.toml").write_text(shown, encoding="utf-8")
    shown_setup, bundled = bc.load_setup("shown.toml"), bc.load_setup("setup.toml")
    for name in ("position", "width", "height", "c_from_bottom"):
        assert getattr(shown_setup, name) == getattr(bundled, name)


@pytest.mark.parametrize("name", list(COMMANDS))
def test_every_command_is_in_the_readme(name):
    assert f"bayescal {name}" in (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [n for n in bc.__all__ if not n.startswith("_")])
def test_every_public_name_is_on_the_page_about_python(name):
    assert f"`{name}`" in (ROOT / "docs" / "api.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), target


def test_versions_agree():
    assert f"version: {bc.__version__}" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## {bc.__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
