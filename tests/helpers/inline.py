"""Workers without processes, which take a second or two to start."""

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any


class InlineWorkers:
    """Stands in for `Workers`: does its work at once, in this process."""

    def __init__(self, size: int) -> None:
        self.size = size

    def give(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def __enter__(self) -> "InlineWorkers":
        return self

    def __exit__(self, *_: object) -> None:
        pass
