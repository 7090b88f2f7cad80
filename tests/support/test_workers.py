"""Worker processes are started whole, or not at all."""

import signal
import threading

import pytest

from tegotae._support.workers import ctrl_c_held_back


def interrupted_elsewhere() -> None:
    """Ctrl-C that reaches another thread, for which Python interrupts the main one."""

    def interrupting() -> None:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupting)
    thread.start()
    thread.join()


def test_ctrl_c_waits_until_a_worker_has_started():
    finished = []
    with pytest.raises(KeyboardInterrupt), ctrl_c_held_back():  # noqa: PT012
        interrupted_elsewhere()
        finished.append("started")
    assert finished == ["started"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_without_ctrl_c_nothing_is_left_behind():
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, set())
    with ctrl_c_held_back():
        assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, set())
    assert signal.pthread_sigmask(signal.SIG_BLOCK, set()) == previous
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
