"""What is published beside the code: manual, completions, documentation, links, the workflow.

Truth: the command's own parser, and the files themselves.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import bayescal as bc
from bayescal.cli import COMMANDS
from scripts.extra_files import made
from tests.helpers.command import environment

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_manual_and_the_completions_know_every_command(tmp_path: Path) -> None:
    texts = made()
    for name, text in texts.items():
        for command in COMMANDS:
            assert command in text, name
        assert "--columns" in text.replace("\\-", "-"), name
    (tmp_path / "bayescal.bash").write_text(texts["bayescal.bash"])
    script = "source bayescal.bash; complete -p bayescal; echo ${_shtab_bayescal_subparsers[@]}"
    done = subprocess.run(
        ["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert set(COMMANDS) <= set(done.stdout.split())
    assert made() == texts


def test_the_site_is_built_and_no_link_in_it_is_broken(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "docs", tmp_path],
        cwd=ROOT, env=environment(), capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    for page in (ROOT / "docs").glob("*.md"):
        assert (tmp_path / f"{page.stem}.html").is_file()
    about_python = (tmp_path / "api.html").read_text(encoding="utf-8")
    for name in set(bc.__all__) - {"__version__"}:
        assert f'id="bayescal.{name}"' in about_python


def test_links_of_the_readme_are_absolute_on_the_package_index() -> None:
    """By the substitutions that the build makes; every target exists here."""
    hook = PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = readme
    for rule in hook["substitutions"]:
        shown = re.sub(rule["pattern"], rule["replacement"], shown)
    relative = re.findall(r"\]\((?!https?:|#)([^)]+)\)", readme)
    assert relative
    assert not re.findall(r"\]\((?!https?:|#)([^)]+)\)", shown)
    source = PROJECT["project"]["urls"]["Source"]
    for target in relative:
        assert target in shown
        assert (ROOT / target.partition("#")[0]).exists()
    own = re.findall(r"https://(?:github|raw\.githubusercontent)\.com/[^/]+/bayescal/", shown)
    assert {link.split("/")[3] for link in own} == {source.split("/")[3]}
    assert source in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_the_hosted_workflow_runs_what_a_change_must_pass() -> None:
    text = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    job = yaml.safe_load(text)["jobs"]["run"]
    supported = [
        name.rpartition(" ")[2]
        for name in PROJECT["project"]["classifiers"]
        if name.startswith("Programming Language :: Python :: 3.")
    ]
    assert job["strategy"]["matrix"]["python"] == supported
    assert any(step.get("run", "").startswith(".ci/run ") for step in job["steps"])
    assert yaml.safe_load(text)["permissions"] == {"contents": "read"}
    assert "publish" not in text.partition("\n")[2]


@pytest.mark.parametrize("name", ["arviz", "arviz_plots"])
def test_the_package_itself_does_not_need(name: str, tmp_path: Path) -> None:
    """Only arviz_base and arviz_stats are imported, however much is done."""
    script = (
        "import sys, bayescal as bc\n"
        f"sys.modules[{name!r}] = None\n"
        "result = bc.compare(bc.thesis(), [1], axis='r', ess=100, hint=False)\n"
        "bc.save_run(result, 'run'); bc.open_run('run')\n"
    )
    assert not any(re.match(rf"{name}\b(?!-)", need) for need in PROJECT["project"]["dependencies"])
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment(), check=True)
