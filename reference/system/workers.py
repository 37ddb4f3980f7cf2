"""Work that other processes do: those of this machine, or a Dask cluster's."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    Executor,
    Future,
    ProcessPoolExecutor,
    as_completed,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from typing import Any, TypeVar

from restir_gi.reference.system.errors import UsageError

Task = TypeVar("Task")
Result = TypeVar("Result")

CONNECT = "30s"
"""How long a scheduler may take to answer."""


def processors() -> int:
    """Processors that this process may use; at least 1."""
    if hasattr(os, "sched_getaffinity"):  # a container may give us fewer than there are
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def workers(processes: int, scheduler: str | None = None) -> Iterator[Executor]:
    """Processes that wait for work.

    Raises UsageError: Dask is not installed, nobody answers there, or a process was
    ended from outside.

    Parameters
    ----------
    processes : int; on this machine; of no meaning to a cluster
    scheduler : str, optional
        Address of the scheduler of a Dask cluster, whose workers have this project
        installed, and the files of scenes at the same paths.

    Yields
    ------
    Executor; a task of a Dask worker that is lost is done again by another
    """
    if scheduler is not None:
        with _cluster(scheduler) as executor:
            yield executor
        return
    # Spawned, not forked: Embree and OpenBLAS have threads by now.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(processes, context, _live_and_die_with_the_parent)
    try:
        yield pool
    except BrokenProcessPool as error:
        raise UsageError(
            "a worker process was ended from outside; if memory ran out, use fewer"
            " --processes"
        ) from error
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def work(
    executor: Executor, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[tuple[Task, Result]]:
    """Do tasks, and give back each as it is done, (task, result); each task once.

    Parameters
    ----------
    function : callable; of a module, without side effects: a lost task is done again
    tasks : iterable; handed out in this order
    """
    futures = {executor.submit(function, task): task for task in tasks}
    for future in as_completed(futures):
        yield futures.pop(future), future.result()


def ahead(
    executor: Executor,
    function: Callable[[Task], Result],
    tasks: Iterable[Task],
    count: int,
    remaining: Callable[[], float],
) -> Iterator[Result]:
    """Do tasks before their results are wanted, and give them back in order.

    Parameters
    ----------
    function : callable; of a module, without side effects: a lost task is done again
    tasks : iterable; may have no end; as many as have been handed out are done
    remaining : callable; seconds that are left: no result is waited for after that

    Yields
    ------
    result; in the order of the tasks, until the time is over
    """
    waiting: deque[Future[Result]] = deque()
    left = iter(tasks)
    while True:
        for task in islice(left, count - len(waiting)):
            waiting.append(executor.submit(function, task))
        if not waiting:
            return
        seconds = min(max(remaining(), 0.0), threading.TIMEOUT_MAX)
        if not wait([waiting[0]], seconds).done:
            return
        yield waiting.popleft().result()


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError(
            "--scheduler needs Dask; install the extra 'distributed'"
        ) from error
    try:
        connect: Any = Client
        client = connect(address, timeout=CONNECT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {address!r}; give the address that it prints"
            " when it starts, such as tcp://127.0.0.1:8786"
        ) from error
    with client:
        yield client.get_executor()


def _live_and_die_with_the_parent() -> None:
    """Leave interrupts to the parent, and end as soon as it has ended, however."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        parent = multiprocessing.parent_process()
        assert parent is not None
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
