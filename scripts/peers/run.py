"""bayescal against other samplers on one posterior: ESS/s, time to an ESS, memory, evidence.

Every run is a process of its own on one thread, and times are processor time. Cold: from the
start of Python until the first run's end, imports and compilation included; warm: the second run.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import statistics
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from textwrap import wrap
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))

from scripts.peers.chains import Emcee, Lmfit, NumPyro, Nutpie
from scripts.peers.nested import Dynesty, UltraNest
from scripts.peers.own import Bayescal, Direct, Thousand
from scripts.peers.posterior import Posterior
from scripts.peers.sampled import RHAT, Sampler
from scripts.validation.sections import publish

OURS, MANY, DIRECT = "bayescal", "bayescal, 1000 walkers", "closed form, drawn from"
PEERS: dict[str, type[Sampler]] = {
    OURS: Bayescal,
    MANY: Thousand,
    DIRECT: Direct,
    "nutpie": Nutpie,
    "NumPyro": NumPyro,
    "emcee": Emcee,
    "lmfit": Lmfit,
    "dynesty": Dynesty,
    "UltraNest": UltraNest,
}
HEADING = "## Against other samplers"
ORDERS = (1, 3, 5)
ESS = 4000
# What has to be beaten by how much, in effective samples a second at order 5.
LIMITS = {"nutpie": 50, "NumPyro": 300, "emcee": 3000, DIRECT: 0.4}
ONE_THREAD = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "PYTHONWARNINGS": "ignore",
}


def main() -> None:
    """Print the section, or put it into a file; or, as a child, run one peer."""
    parser = argparse.ArgumentParser(prog="scripts/benchmark peers", description=__doc__)
    parser.add_argument("--runs", type=int, default=1, help="of each peer; medians are shown (1)")
    parser.add_argument("--out", metavar="FILE.md", help=f"put the section {HEADING!r} there")
    parser.add_argument("--peer", nargs="+", choices=PEERS, default=list(PEERS), help="only these")
    parser.add_argument("--orders", nargs="+", type=int, default=ORDERS, help="only these")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        name, order, seed = options.one
        print(json.dumps(one(name, int(order), int(seed))))
        return
    lines = list(section(options.peer, options.orders, options.runs))
    publish("\n".join([HEADING, "", *lines]) + "\n", HEADING, options.out)


def one(name: str, order: int, seed: int) -> dict[str, Any]:
    """Run a peer twice in this process: what a run gives, and what both cost."""
    warnings.simplefilter("ignore")
    posterior = Posterior(order)
    sampler = PEERS[name](posterior)
    first = sampler.run(seed, ESS)
    cold = time.process_time()
    second = sampler.run(seed + 1000, ESS)
    return {
        "cold": cold,
        "warm": time.process_time() - cold,
        "first": first._asdict(),
        "second": second._asdict(),
    }


def measured(name: str, order: int, seed: int) -> dict[str, Any]:
    """Run a peer in a process of its own; add its peak memory, MB."""
    command = [sys.executable, __file__, "--one", name, str(order), str(seed)]
    process = subprocess.Popen(
        command, env={**os.environ, **ONE_THREAD}, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stderr is not None
    said = process.stdout.read().decode()
    complaint = process.stderr.read().decode()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{name} at order {order} failed:\n{complaint}")
    return {**json.loads(said.splitlines()[-1]), "memory": used.ru_maxrss / 1e3}


def truth(order: int) -> float:
    """Evidence by brute force: another algebra, another quadrature than the program's."""
    from tests.helpers.brute_force import normal_grid

    posterior = Posterior(order)
    return normal_grid(posterior.linear, posterior.axis.data).log_evidence


def section(peers: list[str], orders: Sequence[int], runs: int) -> Iterator[str]:
    """Yield the tables, and what was missed."""
    told = (
        f"`scripts/benchmark peers --runs {runs}`: the same posterior, r of the thesis's 57 points "
        "under the default prior (Legendre amplitudes, ln sigma and, from order 2 on, ln tau), on "
        "one thread; seconds of processor time, medians. ESS: the worst parameter's, bulk or tail. "
        f"Time to ESS {ESS} with R-hat < {RHAT}: cold, from the start of Python, imports and "
        "compilation included; warm, a second run in the same process; with `~` of a run whose "
        "length is its own, scaled if short. Evidence: its error against brute force, and the "
        "error that was stated.",
        f"{machine()}; {', '.join(versions(peers))}.",
    )
    for paragraph in told:
        yield from (*wrap(paragraph, 104, break_on_hyphens=False), "")
    missed = []
    for order in orders:
        exact = truth(order)
        yield from (
            f"### Order {order}",
            "",
            f"| | ESS/s, warm | of 1000 walkers over it | ESS {ESS}: warm, s | cold, s | R-hat "
            "| memory, MB | evidence: error, nat | stated |",
            "|" + "---|" * 9,
        )
        speed = {}
        for name in peers:
            found = [measured(name, order, seed) for seed in range(runs)]
            speed[name] = statistics.median(f["second"]["ess"] / f["warm"] for f in found)
            told = row(name, found, speed, exact)
            print(f"order {order}: {told}", file=sys.stderr, flush=True)
            yield told
        for name, limit in LIMITS.items():
            ratio = speed.get(MANY, math.nan) / speed.get(name, math.nan)
            if order == ORDERS[-1] and ratio < limit:
                missed.append(f"- Missed: {ratio:.2g} times {name}, where {limit} was wanted.")
        yield ""
    yield from missed


def row(name: str, found: list[dict[str, Any]], speed: dict[str, float], exact: float) -> str:
    """One peer's line: medians over its runs."""

    def median(values: list[float]) -> float:
        return statistics.median(values)

    decides = found[0]["second"]["rhat"] is None
    mark = "~" if decides else ""
    times = []
    for cost, run in (("warm", "second"), ("cold", "first")):
        needed = [f[cost] * (max(ESS / f[run]["ess"], 1) if decides else 1) for f in found]
        reached = decides or all(f[run]["ess"] >= ESS and f[run]["rhat"] < RHAT for f in found)
        times.append(f"{mark}{median(needed):.3g}" if reached else "not reached")
    rhat = "" if decides else f"{max(f['second']['rhat'] for f in found):.3f}"
    error = stated = ""
    if found[0]["second"]["log_evidence"] is not None:
        error = f"{median([abs(f['second']['log_evidence'] - exact) for f in found]):.1e}"
        stated = f"{median([f['second']['error'] for f in found]):.1e}"
    over = f"{speed[MANY] / speed[name]:.3g}" if MANY in speed else ""
    memory = median([f["memory"] for f in found])
    cells = (name, f"{speed[name]:,.0f}", over, *times, rhat, f"{memory:.0f}", error, stated)
    return f"| {' | '.join(cells)} |"


def machine() -> str:
    """Describe the machine."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        named = [
            x.split(":")[1].strip() for x in info.read_text().splitlines() if "model name" in x
        ]
        model = named[0] if named else model
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{model}, {os.cpu_count()} cores{load}, Python {platform.python_version()}"


def versions(peers: list[str]) -> list[str]:
    """Versions of the peers, and of what they run on."""
    packages = [name.lower() for name in peers if name not in (OURS, MANY, DIRECT)]
    beside = [b for n, b in (("nutpie", "pymc"), ("NumPyro", "jax")) if n in peers]
    return [f"{name} {version(name)}" for name in ("numpy", *packages, *beside)]


if __name__ == "__main__":
    main()
