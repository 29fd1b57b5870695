"""The client under trial: it moves the arm, and says in JSON lines what it hears of its moves.

python client.py ADDRESS PROGRAM LEASE_S SEGMENT_S LOW_M HIGH_M
"""

import asyncio
import json
import signal
import sys
import time
from collections.abc import Callable
from typing import Any, Final

from rfms_can.coordinator import Arm, AsyncArm, RfmsError, Transform, connect, connect_async

NAME: Final = "trial"
FAILED: Final = 3
INTERRUPTED: Final = 130


def say(**words: Any) -> None:
    """One line for the trial."""
    print(json.dumps(words), flush=True)


def goal(pose: Transform, low: float, high: float) -> Transform:
    """The same place at the other height, m."""
    z = high if pose.pz < 0.5 * (low + high) else low
    return Transform.translation(0.0, 0.0, z - pose.pz) @ pose


def move(arm: Arm, seconds: float, low: float, high: float) -> int:
    """Request the long move; its number."""
    there = arm.transform("there", goal(arm.pose, low, high))
    arm.position("there", arm.t6 == there)
    arm.mode("slow", segment_time=seconds, acceleration_time=0.2)
    return arm.move("there", "slow")


def waits(arm: Arm, *how: float) -> None:
    """Wait for the move."""
    number = move(arm, *how)
    say(moves=[number])
    arm.wait(number)
    say(claims={number: "made"})


def polls(arm: Arm, *how: float) -> None:
    """The loop of the guide."""
    number = move(arm, *how)
    say(moves=[number])
    while arm.status.completed < number:
        arm.sleep(0.02)
    say(claims={number: arm.outcome(number).how.value})
    arm.wait(number)


def queues(arm: Arm, *how: float) -> None:
    """Several moves, and rest."""
    first = move(arm, *how)
    back = arm.transform("back", arm.pose)
    arm.position("back", arm.t6 == back)
    numbers = [first, arm.move("back", "slow"), arm.move("there", "slow")]
    say(moves=numbers)
    arm.wait()
    say(claims=dict.fromkeys(numbers, "made"))


def computes(arm: Arm, *how: float) -> None:
    """Time stands still for a while in mid-motion: the lease alone is kept."""
    number = move(arm, *how)
    arm.sleep(0.5 * how[0])
    say(moves=[number])
    time.sleep(1.0)
    arm.wait(number)
    say(claims={number: "made"})


PROGRAMS: Final[dict[str, Callable[..., None]]] = {
    program.__name__: program for program in (waits, polls, queues, computes)
}
COROUTINES: Final = "coroutines"


async def coroutines(address: str, lease_s: float, *how: float) -> None:
    """Two parts: one waits, one watches."""
    seconds, low, high = how
    async with connect_async(address, name=NAME, lease_s=lease_s) as arm:
        there = await arm.transform("there", goal(arm.pose, low, high))
        await arm.position("there", arm.t6 == there)
        await arm.mode("slow", segment_time=seconds, acceleration_time=0.2)
        number = await arm.move("there", "slow")
        say(moves=[number])
        await arm.run(arm.wait(number), _watch(arm, number))
        say(claims={number: "made"})


async def _watch(arm: AsyncArm, number: int) -> None:
    while arm.status.completed < number:
        await arm.sleep(0.05)


def main() -> int:
    """Run a program to its end; the exit code."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in background jobs
    address, program = sys.argv[1:3]
    lease_s, *how = map(float, sys.argv[3:])
    try:
        if program == COROUTINES:
            asyncio.run(coroutines(address, lease_s, *how))
        else:
            with connect(address, name=NAME, lease_s=lease_s) as arm:
                PROGRAMS[program](arm, *how)
    except RfmsError as error:
        say(error=type(error).__name__, text=str(error))
        return FAILED
    except KeyboardInterrupt:
        say(error="KeyboardInterrupt", text="")
        return INTERRUPTED
    return 0


if __name__ == "__main__":
    sys.exit(main())
