"""The same study on a Dask cluster: of this machine, or of many."""

from __future__ import annotations

import asyncio
import logging
import socket
import time
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import TYPE_CHECKING

from tegotae._support.documents import Document
from tegotae._support.errors import TegotaeError, require
from tegotae._support.progress import note
from tegotae._support.workers import WorkersDied
from tegotae.study import Cell, CellResult, Pool, measure_all

if TYPE_CHECKING:
    from distributed import Client, Future

LOCAL = "local"
"""Word in place of an address: workers on this machine, one per core."""

_TIMEOUT_S = 10.0
_PATIENCE_S = 1800.0
_LOOK_S = 5.0


def on_cluster(
    address: str, timeout_s: float = _TIMEOUT_S, patience_s: float = _PATIENCE_S
) -> Pool:
    """Run bundles on the Dask workers of the scheduler at `address`; `local` starts some here.

    Workers should have one thread each. Each computes as those of a run without Dask do, or refuses
    (`tegotae.study.measure_all`), so that every unit's numbers are the same. A bundle whose worker
    dies goes to another.

    Args:
        address: such as tcp://host:8786.
        timeout_s: how long to wait for the scheduler to answer [s].
        patience_s: how long to wait for workers while there are none [s].

    Raises:
        TegotaeError: if `distributed` is not installed or the scheduler cannot be reached; from
            the results, if it goes away, or has no workers for too long.
    """
    distributed = require("distributed", "cluster")
    if address != LOCAL:
        _knock(address, timeout_s, patience_s)

    def results(work: Sequence[Sequence[Cell]]) -> Generator[tuple[Cell, CellResult], None, None]:
        with _client(distributed, address, timeout_s) as client:
            futures = {client.submit(measure_all, bundle, pure=False): bundle for bundle in work}
            completed = _as_they_come(distributed, client, futures, address, patience_s)
            while True:
                try:
                    future = next(completed, None)
                    if future is None:
                        return
                    outcomes = future.result()
                except distributed.KilledWorker:
                    raise WorkersDied from None
                except ImportError as error:
                    raise TegotaeError(
                        f"a Dask worker cannot run the study, as it lacks a package: {error}"
                    ) from None
                except (distributed.CancelledError, distributed.comm.CommClosedError):
                    raise TegotaeError(f"the Dask scheduler at {address} went away") from None
                yield from zip(futures[future], outcomes, strict=True)

    return results


def _as_they_come(
    distributed: ModuleType,
    client: Client,
    futures: Iterable[Future],
    address: str,
    patience_s: float,
) -> Iterator[Future]:
    """Yield futures as they finish. A missing worker is reported, and tolerated for a time."""
    pending, alone_since, warned = set(futures), None, not client.scheduler_info()["workers"]
    while pending:
        completed: set[Future] = set()
        with suppress(TimeoutError):
            waited = distributed.wait(pending, timeout=_LOOK_S, return_when="FIRST_COMPLETED")
            completed = set(waited.done)
        pending -= completed
        yield from completed
        if completed or client.scheduler_info()["workers"]:
            alone_since, warned = None, False
            continue
        time_s = time.monotonic()
        alone_since = time_s if alone_since is None else alone_since
        if time_s - alone_since > patience_s:
            raise TegotaeError(
                f"the Dask scheduler at {address} has had no workers for {patience_s:g} s"
            )
        if not warned:
            _warn_of_no_workers(address, patience_s)
            warned = True


def _warn_of_no_workers(address: str, patience_s: float) -> None:
    note(f"the Dask scheduler at {address} has no workers; waiting {patience_s:g} s for some")


@contextmanager
def _client(distributed: ModuleType, address: str, timeout_s: float) -> Iterator[Client]:
    try:
        if address == LOCAL:
            client = distributed.Client(
                threads_per_worker=1,
                processes=True,
                # It always has a web server: for this machine alone, at any port, no dashboard.
                scheduler_kwargs={"dashboard": False, "dashboard_address": "127.0.0.1:0"},
                silence_logs=logging.ERROR,
            )
        else:
            client = distributed.Client(address, timeout=timeout_s)
    except (OSError, TimeoutError, ValueError) as error:
        raise _unreachable(address, str(error) or type(error).__name__) from None
    with client:
        yield client


def _knock(address: str, timeout_s: float, patience_s: float) -> None:
    """Check that a scheduler answers; a client retries for long, and gives no reason.

    One without workers would be waited for in silence, so it is reported.
    """
    distributed = require("distributed", "cluster")
    place = require("distributed.comm", "cluster").get_address_host_port

    async def greet(options: dict[str, object]) -> Document:
        greeting = require("distributed.core", "cluster").connect(address, **options)
        talk = await asyncio.wait_for(greeting, timeout_s)
        try:
            await talk.write({"op": "identity", "reply": True})
            return dict(await asyncio.wait_for(talk.read(), timeout_s))
        finally:
            talk.abort()

    try:
        with socket.create_connection(place(address), timeout_s):
            pass
        options = distributed.Security().get_connection_args("client")
    except TimeoutError:
        raise _unreachable(address, f"no answer within {timeout_s:g} s") from None
    except OSError as error:
        raise _unreachable(address, error.strerror or str(error)) from None
    except (OverflowError, TypeError, ValueError) as error:  # no address, or no certificates
        raise _unreachable(address, str(error)) from None
    try:
        reply = asyncio.run(greet(options))
    except TimeoutError:
        raise _unreachable(address, f"no answer within {timeout_s:g} s") from None
    except Exception:  # another protocol's words are taken for anything, such as sizes
        raise _unreachable(address, "what answers does not speak as one") from None
    if reply.get("type") != "Scheduler":
        raise _unreachable(address, f"a {reply.get('type', 'stranger')} answers there")
    if not reply.get("workers"):
        _warn_of_no_workers(address, patience_s)


def _unreachable(address: str, reason: str) -> TegotaeError:
    return TegotaeError(
        f"no Dask scheduler can be reached at {address!r}: {reason.splitlines()[0]}"
    )
