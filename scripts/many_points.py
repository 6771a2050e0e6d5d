"""Time and memory of a comparison from 57 to ten million points; a reduction's speed and digits."""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from benchmark import spent

from bayescal.linear.least_squares import factorise
from bayescal.linear.reduction import Reduction
from bayescal.polynomials.axis_data import generic_axis

COUNTS = (57, 1_000, 100_000, 1_000_000, 10_000_000)
CAMERA = ("--image-width", "1920", "--image-height", "1080")
COMMAND = [sys.executable, "-m", "bayescal", "compare", "--orders", "1-5", "--json", "-", *CAMERA]
# Words, what is asked beside the file, and of how many points.
ASKED: tuple[tuple[str, tuple[str, ...], tuple[int, ...]], ...] = (
    (
        "`compare --family separable,bivariate`, orders 1-5",
        ("compare", "--family", "separable,bivariate"),
        (100_000, 1_000_000, 10_000_000),
    ),
    (
        "`fit --noise student-t --order-r 3`",
        ("fit", "--noise", "student-t", "--order-r", "3"),
        (20_000, 100_000, 1_000_000),
    ),
    (
        "`fit --noise outlier-mixture --order-r 3`",
        ("fit", "--noise", "outlier-mixture", "--order-r", "3"),
        (1_000_000,),
    ),
)
ORDER = 5
CHUNK = 65536


def points(n: int, sigma: float = 1.0, seed: int = 0) -> np.ndarray:
    """x, y, z, r, c of a camera at the origin, r of order 3 and c of order 1."""
    rng = np.random.default_rng(seed)
    z, w, u = (rng.uniform(low, high, n) for low, high in ((300, 900), (-0.6, 0.6), (-0.35, 0.35)))
    r = 960 + 1500 * w + 10 * w**2 - 60 * w**3 + sigma * rng.standard_normal(n)
    return np.column_stack([w * z, u * z, z, r, 540 + 1500 * u + sigma * rng.standard_normal(n)])


def write(path: Path, n: int) -> None:
    """Write points chunk by chunk: a process that starts another lends it its peak memory."""
    with path.open("wb") as stream:
        head = {"descr": "<f8", "fortran_order": False, "shape": (n, 5)}
        np.lib.format.write_array_header_1_0(stream, head)
        for i in range(0, n, CHUNK):
            points(min(CHUNK, n - i), seed=i).tofile(stream)


def reduce(x: np.ndarray, t: np.ndarray, order: int) -> Reduction:
    """Reduce in chunks as a file's."""
    reduction = Reduction(order)
    for i in range(0, len(x), CHUNK):
        reduction.add(x[i : i + CHUNK], t[i : i + CHUNK])
    return reduction


def least(work: object, runs: int = 5) -> float:
    """Smallest processor time of a few runs of a callable, s."""
    found = []
    for _ in range(runs):
        start = time.process_time()
        work()
        found.append(time.process_time() - start)
    return min(found)


def speed(n: int = 2_000_000) -> str:
    """Reduction of one axis over a dot product of the same [design | pixel] with itself."""
    table = points(n)
    x, t = table[:, 0] / table[:, 2], table[:, 3].copy()
    array = np.random.default_rng(0).standard_normal(n * (ORDER + 2))
    dot, ours = least(lambda: array @ array), least(lambda: reduce(x, t, ORDER))
    return (
        f"The reduction of {n:,} points at order {ORDER}, its design made on the way, runs at "
        f"{100 * dot / ours:.0f} % of the speed of numpy's dot product over an array as large as "
        f"[design | pixel] ({1e9 * ours / n:.0f} ns a point)."
    )


def digits(n: int = 1_000_000, sigma: float = 1e-3) -> str:
    """Error of n/2 ln rss, the part of log evidence that rounding reaches, against long doubles."""
    table = points(n, sigma)
    x, t = table[:, 0] / table[:, 2], table[:, 3].copy()
    data = generic_axis(x, t)
    long = np.longdouble
    s = (x.astype(long) - data.domain.middle) / data.domain.half_range
    left, columns = t.astype(long), [np.ones(n, long), s]
    for k in range(1, ORDER):
        columns.append(((2 * k + 1) * s * columns[k] - k * columns[k - 1]) / (k + 1))
    basis: list[np.ndarray] = []
    for column in columns:
        for _ in range(2):  # Gram and Schmidt, twice
            for q in basis:
                column = column - q * (q @ column)
        basis.append(column / np.sqrt(column @ column))
        for _ in range(2):  # the second pass over the residuals
            left = left - basis[-1] * (basis[-1] @ left)
    truth = left @ left
    chunks = data.sampled_from(reduce(x, t, ORDER).whole())
    chunked, whole = (
        abs(float(n / 2 * (long(factorise(d, ORDER).rss(ORDER)) / truth - 1)))
        for d in (chunks, data)
    )
    return (
        f"At n = {n:,} and sigma = {sigma:g} px rounding moves log evidence by {chunked:.0e} nat "
        f"against two passes in long doubles (one QR of all points at once: {whole:.0e} nat)."
    )


def main() -> None:
    """Print two tables and two sentences."""
    most = float(sys.argv[1] if len(sys.argv) > 1 else "inf")
    print("| points | processor time, s | peak memory, MB |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.npy"
        for n in [n for n in COUNTS if n <= most]:
            write(path, n)
            used, memory = spent([*COMMAND, str(path)])
            print(f"| {n:,} | {used:.1f} | {memory:.0f} |", flush=True)
        print("\n| | points | processor time, s | peak memory, MB |\n|---|---|---|---|")
        for words, asked, counts in ASKED:
            for n in [n for n in counts if n <= most]:
                write(path, n)
                command = [*COMMAND[:3], *asked, "--json", "-", *CAMERA, str(path)]
                used, memory = spent(command)
                print(f"| {words} | {n:,} | {used:.0f} | {memory:.0f} |", flush=True)
    print(f"\n{speed()}\n{digits()}")


if __name__ == "__main__":
    main()
