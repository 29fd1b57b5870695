#!/usr/bin/env python3
"""Cycles per second of the whole loop on the simulated bus, on one core, and where they go.

Beside it, in the same run: the bare MuJoCo steps of a cycle, and the frames of a cycle through
python-can's ``virtual`` bus. Ratios are what to quote; absolute times are this machine's.
"""

import argparse
import gc
import json
import time
from collections.abc import Callable
from statistics import median
from typing import Any

import can
import mujoco
from rich.console import Console
from rich.table import Table

from rfms_can.arm import ARMS, arm_by_name, friction_set
from rfms_can.coordinator import Arm, Transform
from rfms_can.dynamics.model import KINDS
from rfms_can.kinematics import InverseKinematics, configuration_of, direct
from rfms_can.node.endpoint import Endpoint
from rfms_can.plant.arm_model import ArmModel
from rfms_can.rig.candump import cycles_from_enable
from rfms_can.rig.session import Session
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.protection import Decoder, Refusal, Sender

STEPS = 4  # physics steps of a 4 ms period


def loop(cycles: int, settings: RunSettings) -> Session:
    """A session that is enabled and has run a little."""
    session = Session(SimulatedRig(settings))
    session.bring_up()
    run(session, min(100, cycles))
    return session


def run(session: Session, cycles: int) -> float:
    """Microseconds a cycle of so many more cycles, with the arm moving to and fro."""
    until = session.master.closed + cycles
    began = time.perf_counter()
    session.link.pass_time(lambda: session.master.closed >= until)
    return (time.perf_counter() - began) / cycles * 1e6


def keep_moving(session: Session) -> None:
    """Queue Cartesian and joint moves to and fro for as long as a bench may take."""
    arm = Arm(session.link)
    here = arm.transform("here", arm.pose)
    aside = arm.transform("aside", Transform.translation(0.0, 0.03, -0.04))
    places = [
        arm.position("start", arm.t6 == here),
        arm.position("end", arm.t6 == here @ aside),
    ]
    modes = [
        arm.mode("straight", segment_time=0.8, acceleration_time=0.2, interpolation="cartesian"),
        arm.mode("swing", segment_time=0.8, acceleration_time=0.2),
    ]
    for number in range(200):
        arm.move(places[(number + 1) % 2], modes[number // 2 % 2])


def breakdown(cycles: int, settings: RunSettings) -> dict[str, float]:
    """Microseconds a cycle in each node; the rest is the bus and the event loop."""
    session = loop(cycles, settings)
    keep_moving(session)
    spent: dict[str, float] = {}

    def timed(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(*args: Any) -> Any:
            began = time.perf_counter()
            answer = call(*args)
            spent[name] = spent.get(name, 0.0) + time.perf_counter() - began
            return answer

        return wrapper

    rig = session.rig
    assert isinstance(rig, SimulatedRig)
    groups: dict[str, list[Endpoint]] = {
        "master": [rig.master],
        "plant": [rig.plant],
        "nodes": [*rig.joints, rig.gripper],
    }
    for name, nodes in groups.items():
        for node in nodes:
            for method in ("on_frame", "on_time"):
                setattr(node, method, timed(name, getattr(node, method)))
    rig.bus.reroute()
    total = run(session, cycles)
    parts = {name: seconds / cycles * 1e6 for name, seconds in spent.items()}
    return {**parts, "bus": total - sum(parts.values())}


def one_cycle(wire: Wire) -> list[Frame]:
    """The frames of an ordinary cycle (no heartbeats)."""
    rig = SimulatedRig(RunSettings())
    frames: list[Frame] = []
    rig.observe(lambda _, frame: frames.append(frame))
    session = Session(rig)
    session.bring_up()
    run(session, 20)
    return [Frame(identifier, data) for identifier, data in cycles_from_enable(frames, wire)[6]]


def codec(frames: list[Frame], wire: Wire, repeats: int) -> float:
    """Microseconds to decode every frame of a cycle once and to pack and protect it again."""
    by_id = {codec.id: codec for codec in wire.codecs.values()}
    work = [(Decoder(by_id[f.id]), by_id[f.id], f) for f in frames]
    jobs = []
    for decoder, compiled, frame in work:
        jobs.append((decoder, Sender(compiled), frame, Frame(frame.id, bytes(frame.data))))
    began = time.perf_counter()
    for _ in range(repeats):
        for decoder, sender, one, other in jobs:
            values = decoder.decode(other if decoder.frame is one else one)
            assert not isinstance(values, Refusal)
            sender.frame(*values)
    return (time.perf_counter() - began) / repeats * 1e6


def bare_physics(repeats: int) -> float:
    """Microseconds of a cycle's MuJoCo steps alone: no friction, no boards."""
    arm = arm_by_name("puma260")
    model = ArmModel(arm, friction_set(arm, "none"))
    engine, data = model.engine
    began = time.perf_counter()
    for _ in range(repeats):
        for _ in range(STEPS):
            mujoco.mj_step(engine, data)
    return (time.perf_counter() - began) / repeats * 1e6


def python_can(frames: list[Frame], repeats: int) -> float:
    """Microseconds to send a cycle's frames through python-can's virtual bus and receive them."""
    messages = [
        can.Message(arbitration_id=f.id, data=f.data, is_fd=True, is_extended_id=False)
        for f in frames
    ]
    with (
        can.Bus(interface="virtual", channel="bench", protocol=can.CanProtocol.CAN_FD) as sender,
        can.Bus(interface="virtual", channel="bench", protocol=can.CanProtocol.CAN_FD) as receiver,
    ):
        began = time.perf_counter()
        for _ in range(repeats):
            for message in messages:
                sender.send(message)
            for _ in messages:
                receiver.recv(1.0)
        return (time.perf_counter() - began) / repeats * 1e6


def inverse(repeats: int) -> float:
    """Microseconds of one full inverse solution: six joints, one branch."""
    arm = arm_by_name("puma260")
    solve = InverseKinematics(arm).solve
    t6, configuration = direct(arm, arm.park), configuration_of(arm, arm.park)
    began = time.perf_counter()
    for _ in range(repeats):
        solve(t6, configuration, arm.park)
    return (time.perf_counter() - began) / repeats * 1e6


def measure(cycles: int, runs: int, settings: RunSettings) -> dict[str, Any]:
    """All figures; the loop and what it is compared with are run in turn."""
    wire = Wire()
    frames = one_cycle(wire)
    session = loop(cycles, settings)
    keep_moving(session)
    gc.collect()
    gc.freeze()
    loops, physics, cans = [], [], []
    for _ in range(runs):
        loops.append(run(session, cycles))
        physics.append(bare_physics(cycles))
        cans.append(python_can(frames, max(cycles // 10, 1)))
    whole = median(loops)
    return {
        "cycles_per_s": 1e6 / whole,
        "times_real_time": 1e6 / whole / 250.0,
        "cycle_us": whole,
        "cycle_us_runs": loops,
        "breakdown_us": {
            **breakdown(cycles, settings),
            "codec (in the others)": codec(frames, wire, 200),
        },
        "frames_a_cycle": len(frames),
        "bare_mujoco_us": median(physics),
        "python_can_virtual_us": median(cans),
        "loop_over_bare_mujoco": whole / median(physics),
        "loop_over_python_can_virtual": whole / median(cans),
        "inverse_solution_us": inverse(20_000),
    }


def show(figures: dict[str, Any]) -> None:
    """The figures as a table."""
    table = Table(title="whole loop on the simulated bus, one core", title_justify="left")
    table.add_column("what")
    table.add_column("us a cycle", justify="right")
    table.add_column("part of the loop", justify="right")
    whole = figures["cycle_us"]
    table.add_row("loop", f"{whole:.0f}", "1.00", style="bold")
    for name, value in figures["breakdown_us"].items():
        table.add_row(f"  {name}", f"{value:.0f}", f"{value / whole:.2f}")
    for name, key in (
        ("bare MuJoCo steps", "bare_mujoco_us"),
        ("same frames, python-can virtual bus", "python_can_virtual_us"),
    ):
        table.add_row(name, f"{figures[key]:.0f}", f"{figures[key] / whole:.2f}")
    console = Console()
    console.print(table)
    console.print(
        f"{figures['cycles_per_s']:.0f} cycles/s, {figures['times_real_time']:.1f} times real time "
        f"at 250 Hz; one inverse solution {figures['inverse_solution_us']:.1f} us"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cycles", type=int, default=1000, help="cycles in a run")
    parser.add_argument("--runs", type=int, default=5, help="runs; medians are printed")
    parser.add_argument("--json", action="store_true", help="one JSON object")
    parser.add_argument("--arm", default="puma260", help=" | ".join(ARMS))
    parser.add_argument("--dynamics", default="full", help=" | ".join(KINDS))
    parser.add_argument("--calibration", default="", help="what rfms identify has written")
    options = parser.parse_args()
    settings = RunSettings(
        arm=options.arm, dynamics=options.dynamics, calibration=options.calibration
    )
    figures = measure(options.cycles, options.runs, settings)
    if options.json:
        print(json.dumps(figures))
    else:
        show(figures)


if __name__ == "__main__":
    main()
