"""Running a task: its requests, one after the other, and what is cleaned up at the end."""

from collections.abc import Generator, Iterable, Iterator
from contextlib import suppress
from inspect import isawaitable
from typing import Any, TypeVar

from rfms_can.coordinator import Arm, AsyncArm, RfmsError
from rfms_can.task.definitions import DefineMode, DefinePosition, DefineTransform, Definition
from rfms_can.task.steps import Doing, Request, Run, Step

Result = TypeVar("Result")

_KINDS: tuple[tuple[type[Definition], str], ...] = (
    (DefinePosition, "position"),
    (DefineMode, "mode"),
    (DefineTransform, "transform"),
)
"""Definitions in the order they may be removed in: a position before its transforms."""


def drive(doing: Generator[Request, Any, Result], arm: Arm) -> Result:
    """Make the requests of an arm; what the generator returns, or raises."""
    try:
        request = next(doing)
        while True:
            try:
                answer = request(arm)
            except Exception as error:
                request = doing.throw(error)
            else:
                request = doing.send(answer)
    except StopIteration as done:
        result: Result = done.value
        return result


async def drive_async(doing: Generator[Request, Any, Result], arm: AsyncArm) -> Result:
    """:func:`drive` for coroutines."""
    try:
        request = next(doing)
        while True:
            try:
                answer = request(arm)
                if isawaitable(answer):
                    answer = await answer
            except Exception as error:
                request = doing.throw(error)
            else:
                request = doing.send(answer)
    except StopIteration as done:
        result: Result = done.value
        return result


def doing_of(steps: Iterable[Step], run: Run, *, keep: bool) -> Doing:
    """All a task requests: its steps, then its names removed; after an error it stops first.

    Only the moves of the task are stopped: if it has made none, those of the program go on.
    """
    steps = tuple(steps)
    try:
        for step in steps:
            yield from step.calls(run)
        if run.moves:
            yield from run.wait(run.moves[-1])
        for number in run.moves:
            run.outcomes.append((yield from run.outcome(number)))
    except Exception:
        if run.moves:
            yield from _leniently(lambda arm: arm.stop())
        if not keep:
            for request in _removals(steps, run):
                yield from _leniently(request)
        raise
    if not keep:
        yield from _removals(steps, run)


def _removals(steps: tuple[Step, ...], run: Run) -> Iterator[Request]:
    """Requests that take the names away."""
    for kind, what in _KINDS:
        for step in steps:
            if isinstance(step, kind):
                yield _removal(run.scope.full(step.name), what)


def _removal(name: str, what: str) -> Request:
    return lambda arm: arm.remove(name, what)


def _leniently(request: Request) -> Doing:
    """A request that may be refused: there is an error already."""
    with suppress(RfmsError):
        yield request
