"""Tasks spread over processes or machines by Dask."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from bayescal.errors import BayescalError, InputError
from bayescal.version import __version__

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD = 256  # tasks that a scheduler holds at least; more come as these are done
# What a worker need not do of its own: take samples of its own stack every hundredth of a second,
# and look at its clock every fiftieth. It is a tenth of a core. Nor give all memory that it frees
# back to the system at once, as Dask tells malloc: each array of 128 kB and more would be mapped,
# zeroed and unmapped, which took as long as all that was computed.
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), 1
    ),
}
PATIENCE = 30  # seconds that a scheduler and its first worker have to answer


@dataclass(frozen=True)
class Task:
    """One call: its key (a task done anew has the same), and what is given to the function."""

    key: str
    arguments: tuple[Any, ...]


@contextlib.contextmanager
def connected(scheduler: str | None, workers: int | None) -> Iterator[Client]:
    """Connect to a scheduler, or start processes of one thread each on this machine.

    Parameters
    ----------
    scheduler : str or None
        Address of a Dask scheduler, such as ``"tcp://host:8786"``.
    workers : int or None
        Processes to start where no scheduler is named; by default as many as there are cores.

    Raises
    ------
    InputError
        Where the scheduler can't be reached or has no worker, or a worker has another version of
        bayescal or none.
    """
    import dask
    from distributed import Client, LocalCluster

    if scheduler is None:
        with dask.config.set(QUIET), _deaf_to_interrupts():
            local = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address=":0",  # with none it takes a port all the same, and warns
                silence_logs=100,  # nothing: what matters of a worker's end comes as a result
            )
        with local, Client(local) as client:
            yield client
        return
    try:
        client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        why = str(error).split("\n")[0][:120] or type(error).__name__
        raise InputError(
            f"scheduler {scheduler}: can't be reached ({why}); start one with dask scheduler"
        ) from None
    with client:
        _check(client, scheduler)
        yield client


@contextlib.contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Let processes that are started here leave Ctrl-C to the one that started them."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only there can it be said
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _check(client: Client, scheduler: str) -> None:
    """Refuse a cluster without workers, or whose workers are of another version."""
    from distributed import TimeoutError as NoWorker

    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except (NoWorker, TimeoutError):
        raise InputError(
            f"scheduler {scheduler}: has no worker; start some with dask worker {scheduler}"
        ) from None
    try:
        versions = client.run(_version)
    except ImportError:
        raise InputError(
            f"scheduler {scheduler}: its workers have no bayescal; install {__version__} there"
        ) from None
    for worker, found in versions.items():
        if found != __version__:
            raise InputError(f"worker {worker}: has bayescal {found}; install {__version__} there")


def _version() -> str:
    return __version__


def spread(
    client: Client, function: Callable[..., Any], tasks: Iterable[Task]
) -> Iterator[tuple[Task, Any]]:
    """Call a function on many arguments; give each task with what came of it, as they are done.

    The tasks of a worker that ends are done again by others; what ends several workers is given
    up. What comes of a task that failed is its exception.

    Raises
    ------
    BayescalError
        Where the cluster is lost.
    """
    from distributed import as_completed

    waiting = iter(tasks)
    ahead = max(AHEAD, 2 * sum(client.nthreads().values()))
    going: dict[Future[Any], Task] = {}

    def submit(some: int) -> list[Future[Any]]:
        new = {
            client.submit(function, *task.arguments, key=f"bayescal-{task.key}", pure=False): task
            for task in islice(waiting, some)
        }
        going.update(new)
        return list(new)

    done = as_completed(submit(ahead), loop=client.loop)
    for future in done:
        task = going.pop(future)
        yield task, _outcome(future)
        del future  # the scheduler forgets it
        for new in submit(1):
            done.add(new)


def _outcome(future: Future[Any]) -> Any:
    from concurrent.futures import CancelledError

    try:
        if future.status == "cancelled":
            raise CancelledError
        # What a worker had that ended before it was asked is computed again, and waited for.
        error = future.exception()
        return future.result() if error is None else error
    except (CancelledError, OSError):
        raise BayescalError("the scheduler was lost; run again to go on") from None
