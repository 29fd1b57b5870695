"""The program API for coroutines: the methods of :class:`Arm`, awaited.

::

    async def main():
        async with connect_async("rfms") as arm:
            await arm.run(carry(arm), watch(arm))

Arguments, results and errors are those of :class:`Arm`.
"""

import asyncio
import time
from collections.abc import Coroutine, Sequence
from typing import Any, Unpack

from rfms_can.coordinator import definitions
from rfms_can.coordinator.definitions import IDENTITY, LOOK_S, REST_AFTER_S
from rfms_can.coordinator.equation import Equation, Expression
from rfms_can.coordinator.gripper import AsyncGripper
from rfms_can.coordinator.link import AsyncLink
from rfms_can.coordinator.mode_settings import ModeSettings
from rfms_can.coordinator.moves import Moves
from rfms_can.coordinator.stopping import judge
from rfms_can.coordinator.view import ArmView
from rfms_can.errors import ProgramError
from rfms_can.messages import (
    AnyFunction,
    Enabled,
    MoveOutcome,
    PauseRequest,
    ResetRequest,
    ResumeRequest,
    StopRequest,
    TareRequest,
)
from rfms_can.messages.world import Predict, What
from rfms_can.transform import Transform


class AsyncArm(ArmView):
    """The arm of a user program of coroutines.

    Attributes:
        t6: the arm itself, in position equations.
        gripper: of the arm.
    """

    def __init__(self, link: AsyncLink, moves: Moves | None = None) -> None:
        super().__init__(link, moves)
        self._link = link
        self.gripper = AsyncGripper(link)

    async def run(self, *parts: Coroutine[Any, Any, Any]) -> list[Any]:
        """Run coroutines concurrently as parts of this program.

        In virtual time and lockstep time advances only while all of them wait for the arm
        (``wait``, ``sleep``, the gripper, ``stop``): a part that awaits anything else stops it. In
        real time it advances in any case.

        Returns:
            Their results, in order.

        Raises:
            BaseException: of one of them; the others are cancelled.
        """
        return await self._link.run(*parts)

    # --- the world model ----------------------------------------------------------------------

    async def transform(self, name: str, value: Transform) -> Expression:
        """See :meth:`Arm.transform`."""
        self._moves.redefined(await self._link.request(definitions.value(name, value)))
        return Expression(name)

    async def reference(
        self,
        name: str,
        value: Transform,
        predict: Predict = "hold",
        rest_after: float = REST_AFTER_S,
    ) -> Expression:
        """See :meth:`Arm.reference`."""
        await self._link.request(self._reference(name, value, predict, rest_after))
        return Expression(name)

    async def functional(
        self, name: str, function: AnyFunction, base: Transform = IDENTITY
    ) -> Expression:
        """See :meth:`Arm.functional`."""
        message = definitions.functional(name, function, base)
        self._moves.redefined(await self._link.request(message))
        return Expression(name)

    async def observe(
        self,
        reference: str | Expression,
        value: Transform,
        at: float | None = None,
        twist: Sequence[float] | None = None,
    ) -> None:
        """See :meth:`Arm.observe`."""
        await self._link.request(self._observation(reference, value, at, twist))

    async def grant(
        self, sensor: str, references: Sequence[str | Expression], within: float = 0.0
    ) -> None:
        """See :meth:`Arm.grant`."""
        request = definitions.grant(sensor, references)
        until = time.monotonic() + definitions.patience(sensor, within)
        await self._link.request(request)
        while within and self.status.sensors.get(sensor) != "live":
            if time.monotonic() >= until:
                raise definitions.absent(sensor, within, self.status.sensors)
            await asyncio.sleep(LOOK_S)
            await self._link.request(request)

    async def position(
        self,
        name: str,
        equation: Equation,
        *,
        tool: Expression | None = None,
        compliance: Expression | None = None,
        config: str | None = None,
    ) -> str:
        """See :meth:`Arm.position`."""
        message = definitions.position(name, equation, tool, compliance, config)
        self._moves.redefined(await self._link.request(message))
        return name

    async def joint_position(self, name: str, angles: Sequence[float]) -> str:
        """See :meth:`Arm.joint_position`."""
        message = definitions.joint_position(name, angles)
        self._moves.redefined(await self._link.request(message))
        return name

    async def mode(self, name: str, **settings: Unpack[ModeSettings]) -> str:
        """See :meth:`Arm.mode`."""
        self._moves.redefined(await self._link.request(definitions.mode(name, settings)))
        return name

    async def remove(self, name: str | Expression, what: What | None = None) -> None:
        """See :meth:`Arm.remove`."""
        request = definitions.remove(name, what)
        await self._link.request(request)
        self._removed(request)

    # --- motion -------------------------------------------------------------------------------

    async def move(self, position: str, mode: str) -> int:
        """See :meth:`Arm.move`."""
        return self._moves.took(await self._link.request(definitions.move(position, mode)))

    async def stop(self) -> None:
        """See :meth:`Arm.stop`."""
        await self._link.request(StopRequest())
        await self.wait()

    async def reset(self) -> None:
        """See :meth:`Arm.reset`."""
        await self._link.request(ResetRequest())
        self._moves.tell()
        await self._link.wait(Enabled())

    async def pause(self) -> None:
        """See :meth:`Arm.pause`."""
        await self._link.request(PauseRequest())

    async def resume(self) -> None:
        """See :meth:`Arm.resume`."""
        await self._link.request(ResumeRequest())

    async def feed(self, rate: float) -> None:
        """See :meth:`Arm.feed`."""
        await self._link.request(definitions.feed(rate))

    async def comply(self, word: str, *values: float) -> None:
        """See :meth:`Arm.comply`."""
        await self._link.request(definitions.comply(word, values))

    async def tare(self) -> None:
        """See :meth:`Arm.tare`."""
        try:
            await self._link.request(TareRequest())
        except ProgramError:
            await self.wait()
            await self._link.request(TareRequest())
        await self.sleep(definitions.TARE_S)

    async def lock(self, word: str) -> None:
        """See :meth:`Arm.lock`."""
        await self._link.request(definitions.lock(word))

    async def release(self) -> None:
        """See :meth:`Arm.release`."""
        await self.gripper.open()

    # --- time ---------------------------------------------------------------------------------

    async def wait(self, sequence: int | None = None) -> None:
        """See :meth:`Arm.wait`; without a timeout: another part may resume or stop the arm."""
        await self._link.wait(self._moves.over(sequence))
        await judge(self._link, self._moves, sequence)

    async def outcome(self, sequence: int) -> MoveOutcome:
        """See :meth:`Arm.outcome`."""
        number = self._moves.number(sequence)
        return (await self._link.outcomes(number, number))[0]

    async def sleep(self, seconds: float) -> None:
        """See :meth:`Arm.sleep`."""
        await self._link.wait(self._after(seconds))
