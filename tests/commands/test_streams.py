"""Standard streams that are closed, full, narrow or cut off; nothing half written."""

from __future__ import annotations

import json
import re
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from bayescal.errors import OutputError
from bayescal.files import FolderKind, write_folder
from tests.helpers.command import apart, environment
from tests.helpers.points_files import rows, text, write

SHORT = ("--orders", "1", "--axis", "r", "--ess", "100")
COMMAND = [sys.executable, "-W", "error", "-m", "bayescal"]


@pytest.mark.parametrize(
    "arguments", [("--help",), ("compare", *SHORT), ("compare", *SHORT, "--json", "-")]
)
def test_a_reader_that_goes_away_is_no_error(arguments: tuple[str, ...], tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*COMMAND, *arguments],
        cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdout is not None
    process.stdout.close()  # as head does, only sooner
    _, err = process.communicate()
    assert err == b""
    assert process.returncode == 0


@pytest.mark.parametrize("stream", [">&-", "2>&-", ">&- 2>&- <&-"])
def test_closed_streams_are_no_error(stream: str, tmp_path: Path) -> None:
    for arguments, code in (("--version", 0), ("compare none.csv", 2), ("compare -", 2)):
        closed = f"{stream} <&-" if arguments.endswith("-") else stream
        done = subprocess.run(
            ["sh", "-c", f'"$@" {arguments} {closed}', "sh", *COMMAND],
            cwd=tmp_path, env=environment(), capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == code
        assert "Traceback" not in done.stderr
        if code == 2:
            assert done.stdout == ""  # a complaint never lands where results go


def test_a_terminal_that_knows_only_ascii(tmp_path: Path) -> None:
    points = write(tmp_path, text(rows(20)), "Eichpünktchen.csv")
    tables = apart(
        "compare", points.name, *SHORT, folder=tmp_path, PYTHONIOENCODING="ascii", LC_ALL="C"
    )
    assert (tables.returncode, tables.stderr) == (0, b"")
    assert "RSS px" in tables.stdout.decode("ascii")
    refused = apart("compare", "fehlt-ü.csv", folder=tmp_path, PYTHONIOENCODING="ascii")
    assert refused.returncode == 2
    assert refused.stderr.count(b"\n") == 1


def test_the_document_keeps_every_name_whatever_the_terminal(tmp_path: Path) -> None:
    points = write(tmp_path, text(rows(20)), "Eichpünktchen.csv")
    for encoding in ("latin-1", "ascii"):
        done = apart(
            "compare", points.name, *SHORT, "--json", "-",
            folder=tmp_path, PYTHONIOENCODING=encoding,
        )  # fmt: skip
        assert json.loads(done.stdout)["data"]["source"] == points.name


def test_a_name_that_is_no_text_is_no_error(tmp_path: Path) -> None:
    name = b"points-\xff.csv".decode("utf-8", "surrogateescape")
    (tmp_path / name).write_text(text(rows(20)))
    done = apart("compare", name, *SHORT, "--json", "result.json", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, b"")
    assert json.loads((tmp_path / "result.json").read_bytes())["data"]["n_points"] == 20


def test_standard_input(tmp_path: Path) -> None:
    done = apart("compare", "-", *SHORT, folder=tmp_path, stdin=text(rows(20)).encode())
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.startswith(b"20 points from standard input")


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("compare", "none.csv"), 2),
        (("compare", "--frobnicate"), 2),
        (("compare", *SHORT, "--progress"), 0),
        (("compare", "--orders", "1", "--axis", "r", "--ess", "100", "--seed", "-1"), 2),
    ],
)
def test_a_full_disk_under_standard_error_changes_nothing(
    arguments: tuple[str, ...], code: int, tmp_path: Path
) -> None:
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [*COMMAND, *arguments],
            cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=full,
        )  # fmt: skip
    assert done.returncode == code
    assert done.stdout == apart(*arguments, folder=tmp_path).stdout


@pytest.mark.parametrize("megabytes", [5, 30])
def test_too_little_memory_is_one_line(megabytes: int, tmp_path: Path) -> None:
    """With so much more than the process holds once the libraries of linear algebra are there."""
    script = (
        "import resource, sys\nimport scipy.linalg\nfrom bayescal.cli import main\n"
        "held = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        f"resource.setrlimit(resource.RLIMIT_AS, (held + {megabytes} * 10**6,) * 2)\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, "compare", *SHORT],
        cwd=tmp_path, env=environment(OPENBLAS_NUM_THREADS="1"), capture_output=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stdout == b""
    assert done.stderr.startswith(b"bayescal: ")
    assert done.stderr.count(b"\n") == 1
    assert b"memory" in done.stderr


def test_a_pipe_without_end_is_read_no_further_than_stated(tmp_path: Path) -> None:
    for arguments in ("compare -", "compare points.csv --setup /dev/zero"):
        write(tmp_path, text(rows(20)))
        done = subprocess.run(
            ["sh", "-c", f'yes 1,2,3,4,5 | "$@" {arguments}', "sh", *COMMAND],
            cwd=tmp_path, env=environment(), capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 2
        assert "MB, the most that is read" in done.stderr.splitlines()[-1]
        assert "Traceback" not in done.stderr


def test_an_unusable_backend_of_matplotlib_is_no_business_of_the_command(tmp_path: Path) -> None:
    done = apart(
        "plot", "curve", "--axis", "r", "--orders", "1", "--ess", "100", "--out", "new.png",
        folder=tmp_path, MPLBACKEND="no such backend",
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_dash_is_standard_output_or_refused(tmp_path: Path) -> None:
    page = apart(
        "report", "--out", "-", "--orders", "1", "--axis", "r", "--ess", "100",
        folder=tmp_path, PYTHONIOENCODING="ascii",
    )  # fmt: skip
    assert page.returncode == 0
    assert page.stdout.decode("utf-8").lstrip().startswith("<!DOCTYPE html>")
    assert page.stdout.rstrip().endswith(b"</html>")
    points = apart("simulate", "--order", "1", "--out", "-", folder=tmp_path)
    assert b"\nx,y,z,r,c,label\n" in points.stdout
    for arguments in (
        ("compare", *SHORT, "--out", "-"),
        ("fit", "--order-r", "1", "--out", "-"),
        ("outliers", "--out", "-"),
        ("reproduce", "--out", "-"),
        ("report", "--out", "page.html", "--pdf", "-"),
        ("plot", "curve", "--axis", "r", "--out", "-"),
    ):
        done = apart(*arguments, folder=tmp_path)
        assert done.returncode == 2
        assert done.stderr.startswith(b"bayescal: -: ")
    assert list(tmp_path.iterdir()) == []


def files_of_at_most(size: int) -> Callable[[], None]:
    """Limit how large a file a process may write, as a full disk would."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


@pytest.mark.parametrize(
    ("option", "size"), [("--json", 1_000), ("--out", 1_000), ("--out", 66_000)]
)
def test_a_full_disk_leaves_nothing_behind(option: str, size: int, tmp_path: Path) -> None:
    (tmp_path / "old").write_text("precious")
    done = subprocess.run(
        [*COMMAND, "compare", *SHORT, option, "new"],
        # Python's own cache would be cut off too, and break every later run.
        cwd=tmp_path, env=environment(PYTHONDONTWRITEBYTECODE="1"), capture_output=True, text=True,
        preexec_fn=files_of_at_most(size),
    )  # fmt: skip
    assert done.stdout == ""
    assert re.fullmatch(r"bayescal: new[^:\n]*: file too large\n", done.stderr)
    assert done.returncode == 2
    assert [path.name for path in tmp_path.iterdir()] == ["old"]


@pytest.mark.parametrize("command", [("compare", *SHORT), ("plot", "verdict", "--out", "new.png")])
def test_a_home_that_can_not_be_written_to_is_no_business_of_the_user(
    command: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "home").write_text("no folder")
    homes = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"), str(tmp_path / "home"))
    arguments = command if "plot" not in command else (*command, *SHORT[:2], *SHORT[4:])
    done = apart(*arguments, folder=tmp_path, MPLCONFIGDIR="", **homes)
    assert (done.returncode, done.stderr) == (0, b"")


def test_of_two_runs_into_one_folder_the_second_is_refused(tmp_path: Path) -> None:
    """The second looks while the first is still at work: neither sees the other at first."""
    kind, folder = FolderKind("run", "marker", ()), tmp_path / "run"

    def fill(made: Path) -> None:
        write_folder(folder, kind, lambda other: (other / "marker").write_text("first"))
        (made / "marker").write_text("second")

    with pytest.raises(OutputError, match="holds an earlier run; choose another name"):
        write_folder(folder, kind, fill)
    assert (folder / "marker").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
