"""Whole-process times of bayescal over those of a named peer, run in turn."""

import statistics
import subprocess
import sys
import time

PYTHON = sys.executable
COMPARISONS = [
    (
        "cold `compare --orders 1-5` over importing emcee and arviz_stats",
        [PYTHON, "-m", "bayescal", "compare", "--orders", "1-5"],
        [PYTHON, "-c", "import emcee, arviz_stats"],
        1.5,
    ),
    (
        "`--help` over an empty Python",
        [PYTHON, "-m", "bayescal", "--help"],
        [PYTHON, "-c", "pass"],
        8.0,
    ),
]


def seconds(command: list[str]) -> float:
    """Wall time of one run of a command."""
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main() -> None:
    """Print a row per comparison."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    for name, ours, peer, limit in COMPARISONS:
        for command in (ours, peer):
            seconds(command)  # warm the disk's cache
        pairs = [(seconds(ours), seconds(peer)) for _ in range(runs)]
        ratio = statistics.median(a / b for a, b in pairs)
        mine, other = (statistics.median(side) for side in zip(*pairs, strict=True))
        verdict = "meets" if ratio <= limit else "MISSES"
        print(
            f"{name}: {ratio:.2f} ({mine:.3f} s over {other:.3f} s; median of {runs} pairs; "
            f"{verdict} the limit of {limit:g})"
        )


if __name__ == "__main__":
    main()
