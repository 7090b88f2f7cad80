"""The same study on a Dask cluster: of this machine, or of many."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from tegotae.errors import TegotaeError
from tegotae.extras import require
from tegotae.study.record import Record
from tegotae.study.runner import Results, WorkersDiedError, work_all
from tegotae.study.unit import Unit

LOCAL = "local"
"""In place of an address: workers on this machine, one per core."""

_TIMEOUT_S = 10.0


def on_cluster(address: str, timeout_s: float = _TIMEOUT_S) -> Results:
    """Do bundles on the Dask workers of the scheduler at `address`; `local` starts some here.

    Workers should have one thread each. They are told to use one core, so that every unit's
    numbers are those of a run without Dask. A bundle whose worker dies goes to another.

    Args:
        address: such as tcp://host:8786.
        timeout_s: how long to wait for the scheduler to answer [s].

    Raises:
        TegotaeError: if `distributed` is not installed or the scheduler cannot be reached; from
            the results, if it goes away.
    """
    distributed = require("distributed", "cluster")
    if address != LOCAL:
        _knock(address, timeout_s)

    def results(work_to_do: Sequence[list[Unit]]) -> Generator[tuple[Unit, Record], None, None]:
        with _client(distributed, address, timeout_s) as client:
            futures = {client.submit(work_all, bundle, pure=False): bundle for bundle in work_to_do}
            for future in distributed.as_completed(futures):
                try:
                    records = future.result()
                except distributed.KilledWorker:
                    raise WorkersDiedError from None
                except ImportError as error:
                    raise TegotaeError(
                        f"a Dask worker cannot run the study, as it lacks a package: {error}"
                    ) from None
                except (distributed.CancelledError, distributed.comm.CommClosedError):
                    raise TegotaeError(f"the Dask scheduler at {address} went away") from None
                yield from zip(futures[future], records, strict=True)

    return results


@contextmanager
def _client(distributed: Any, address: str, timeout_s: float) -> Iterator[Any]:
    try:
        if address == LOCAL:
            client = distributed.Client(
                threads_per_worker=1,
                processes=True,
                dashboard_address=None,
                silence_logs=logging.ERROR,
            )
        else:
            client = distributed.Client(address, timeout=timeout_s)
    except (OSError, TimeoutError, ValueError) as error:
        raise _unreachable(address, str(error) or type(error).__name__) from None
    with client:
        environment = require("distributed.diagnostics.plugin", "cluster").Environ
        client.register_plugin(environment({"TEGOTAE_CORES": "1"}))
        yield client


def _knock(address: str, timeout_s: float) -> None:
    """See that a scheduler answers: a client tries again for long, and does not say why."""
    distributed = require("distributed", "cluster")
    place = require("distributed.comm", "cluster").get_address_host_port

    async def greet() -> None:
        options = distributed.Security().get_connection_args("client")
        greeting = require("distributed.core", "cluster").connect(address, **options)
        await (await asyncio.wait_for(greeting, timeout_s)).close()

    try:
        with socket.create_connection(place(address), timeout_s):
            pass
        asyncio.run(greet())
    except TimeoutError:
        raise _unreachable(address, f"no answer within {timeout_s:g} s") from None
    except OSError as error:
        raise _unreachable(address, error.strerror or str(error)) from None
    except (OverflowError, TypeError, ValueError) as error:  # no address, or no certificates
        raise _unreachable(address, str(error)) from None


def _unreachable(address: str, why: str) -> TegotaeError:
    return TegotaeError(f"no Dask scheduler can be reached at {address!r}: {why.splitlines()[0]}")
