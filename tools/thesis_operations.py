"""The operations that the thesis timed, on the objects the nodes run.

Each figure of ``thesis_times.py`` is measured by one entry of ``MEASURES``; ``bench_thesis.py``
prints both side by side.
"""

import os
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache, partial
from typing import Final, NamedTuple

import numpy as np
from bench_cycle import keep_moving, loop, run
from planners.run import Run
from planners.task import TASKS
from planners.thesis import ThesisPlanner
from thesis_times import FIGURES, Figure, Row

from rfms_can.arm import arm_by_name
from rfms_can.arm.load import NOTHING
from rfms_can.bus.budget import Cycle, budget
from rfms_can.bus.stuffing import FD_DLC_LENGTHS
from rfms_can.bus.timing import NS_PER_S, BusTiming
from rfms_can.compliance import LAWS, ControlLaw, Selection, Servos, compliance_jacobian
from rfms_can.dynamics.model import make_dynamics
from rfms_can.joint_nodes.compliance import RowSets
from rfms_can.joint_nodes.servo import Servo
from rfms_can.kinematics import JointSolver, configuration_of, direct
from rfms_can.link.client import ClientSocket
from rfms_can.link.server import ServerSocket
from rfms_can.master.rows.compliance import Compliance
from rfms_can.master.rows.math_processor import MathProcessor
from rfms_can.master.start_up.node_parameters import joint_parameters
from rfms_can.master.trajectory.generator import TrajectoryGenerator
from rfms_can.master.trajectory.goal import Moment
from rfms_can.master.trajectory.segment import Move
from rfms_can.master.trajectory.states import Stage
from rfms_can.master.world.position import Position
from rfms_can.master.world.ring import Ring
from rfms_can.master.world.transform_kinds import Inverse
from rfms_can.messages import PositionMessage
from rfms_can.rig.settings import RunSettings
from rfms_can.rig.simulated import SimulatedRig
from rfms_can.transform import DriveTransform, Transform
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Rows
from rfms_can.wire.vocabulary import Mode, Parameter

COMPONENTS: Final = 10
MESSAGE_BYTES: Final = 36
"""Of the thesis' example: n components, each with a message of o, a and p (VI.2)."""

MOVING_JOINTS: Final = (0.1, -0.2, 0.15, 0.2, 0.25, -0.3)
"""Added to the park pose, rad: a pose at which no angle is special."""
MOVING_CYCLES: Final = 30_000
"""How long the loop's arm is kept moving, cycles: 200 moves of 0.8 s at 250 Hz, and less."""
COMPLIES: Final = Selection.parse("fx fy rx ry")
"""The peg in the hole (5.2)."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How it is measured.

    Attributes:
        arm: name of the arm.
        rate_hz: control rate of the cycles and of the generator.
        repeats: calls in a batch.
        batches: of each operation in a round; a quarter as many of the loop.
        rounds: over all operations, one after the other: the best batch of all counts, which
            leaves out what the machine does besides, also where that takes seconds.
        cycles: of the loop in a batch; 400 hold a straight move and a joint move.
    """

    arm: str = "puma260"
    rate_hz: float = 250.0
    repeats: int = 500
    batches: int = 20
    rounds: int = 5
    cycles: int = 400


def least(settings: Settings, call: Callable[[], object], share: int = 1) -> float:
    """Seconds of a call: the least mean of the batches, of ``repeats / share`` calls each."""
    repeats = range(max(1, settings.repeats // share))
    clock, best = time.perf_counter, float("inf")
    call()
    for _ in range(settings.batches):
        began = clock()
        for _ in repeats:
            call()
        best = min(best, (clock() - began) / len(repeats))
    return best


# --- poses and goals ----------------------------------------------------------------------------


class Renewed:
    """A transform that is another object at each tick: what is kept of it is never valid."""

    cycle_s = 0.0

    def __init__(self, value: Transform) -> None:
        self._values: Final = (value, Transform(*value))
        self._inverse: Final = Inverse()

    def at(self, moment: Moment) -> Transform:
        """The value, new at this tick."""
        return self._values[moment.tick & 1]

    def inverse_at(self, moment: Moment) -> Transform:
        """Its inverse."""
        return self._inverse.of(self.at(moment))


def _joints(settings: Settings) -> tuple[float, ...]:
    park = arm_by_name(settings.arm).park
    return tuple(q + change for q, change in zip(park, MOVING_JOINTS, strict=True))


def _position(settings: Settings, t6: Transform) -> Position:
    """T6 A = B C with T6 at ``t6``."""
    a, b = Transform.translation(0.0, 0.01, 0.1), Transform.rotation((0.0, 0.6, 0.8), 0.3)
    sources = {"a": Renewed(a), "b": Renewed(b), "c": Renewed(b.inverse() @ t6 @ a)}
    ring = Ring(PositionMessage("goal", ["t6", "a"], ["b", "c"]), dict(sources))
    arm = arm_by_name(settings.arm)
    return Position("goal", ring, configuration_of(arm, _joints(settings)))


# --- the operations -----------------------------------------------------------------------------


def _t6(settings: Settings) -> float:
    goal = _position(settings, direct(arm_by_name(settings.arm), _joints(settings))).goal
    moments = (Moment(0), Moment(1))

    def both() -> None:
        goal.pose(moments[0])
        goal.pose(moments[1])

    return least(settings, both) / 2


def _drive_ends(settings: Settings) -> tuple[Transform, Transform, Transform]:
    arm = arm_by_name(settings.arm)
    right = Transform.translation(0.0, 0.01, 0.1).inverse()
    return direct(arm, _joints(settings)) @ right.inverse(), direct(arm, arm.park), right


def _drive(settings: Settings) -> float:
    left, start, right = _drive_ends(settings)
    change = left.inverse() @ start @ right.inverse()

    def parameters() -> None:
        drive = DriveTransform(change)
        _ = drive.theta, drive.phi

    return least(settings, parameters)


def _drive_whole(settings: Settings) -> float:
    left, start, right = _drive_ends(settings)

    def whole() -> None:
        drive = DriveTransform.between(left, start, right)
        _ = drive.theta, drive.phi
        drive.at(0.7)

    return least(settings, whole)


def _inverse(joint: int, settings: Settings) -> float:
    arm, q = arm_by_name(settings.arm), _joints(settings)
    solver, t6, branch = JointSolver(arm, joint), direct(arm, q), configuration_of(arm, q)
    return least(settings, partial(solver.solve, t6, branch, q[joint - 1]))


def _torque(settings: Settings) -> float:
    joint = 2
    period_s = 1.0 / settings.rate_hz
    arm = arm_by_name(settings.arm)
    servo = Servo(joint_parameters(arm, "corke", period_s)[joint], joint)
    math = _math(settings, ControlLaw.HYBRID)
    made = math.rows(
        1, _joints(settings), Compliance().changed(COMPLIES, Transform.identity()), NOTHING
    )
    rows = RowSets(joint)
    rows.activate(Rows(*made.values[joint - 1]))  # type: ignore[arg-type]
    errors, rates = (2e-3, -1e-3, 5e-4, 1e-3, -2e-3, 8e-4), (0.01, -0.02, 0.03, 0.0, 0.01, 0.02)
    accelerations = (0.5, -0.4, 0.3, 0.2, -0.1, 0.6)
    desired, speed = 0.2, 0.21

    def step() -> None:
        friction = servo.friction.complying(desired, speed, servo.state.intended_speed, 7)
        servo.code(servo.torque(errors, rates, accelerations, rows, rows.gravity, friction))

    return least(settings, step)


def _setpoint(settings: Settings) -> float:
    """START of a straight line from a goal that moves to another: the least of all of them."""
    arm = arm_by_name(settings.arm)
    home = _position(settings, direct(arm, arm.park))
    away = _position(settings, direct(arm, _joints(settings)))
    generator = TrajectoryGenerator(1.0 / settings.rate_hz)
    generator.enable(direct(arm, arm.park), home.configuration)
    best, clock = float("inf"), time.perf_counter
    acceleration, segment = 5, 15
    sequence = 0
    for _ in range(max(settings.batches, settings.repeats // 50)):
        for position in (away, home):
            sequence += 1
            generator.request(
                Move(sequence, position.goal, Mode.CARTESIAN, segment, acceleration,
                     position.configuration)
            )  # fmt: skip
        while True:
            began = clock()
            generator.tick()
            ended = clock()
            if generator.stage is Stage.START and generator.sequence == sequence:
                best = min(best, ended - began)
            if generator.at_rest:
                break
    return best


def _rccl(settings: Settings) -> float:
    task = TASKS["corner"](arm_by_name(settings.arm))
    runs = max(1, min(settings.batches, settings.repeats // 50))
    costs = [Run(ThesisPlanner, task, 1.0 / settings.rate_hz).costs_us for _ in range(runs)]
    return float(np.median(np.min(costs, axis=0))) * 1e-6


def _dynamics(kind: str, settings: Settings) -> float:
    q = _joints(settings)
    model = make_dynamics(arm_by_name(settings.arm), kind)

    def update() -> None:
        model.update(q)
        _ = model.J

    return least(settings, update, 4)


def _gains(settings: Settings) -> tuple[list[float], float]:
    """K_p of the six nodes, and their natural frequency."""
    parameters = joint_parameters(arm_by_name(settings.arm), "corke", 1.0 / settings.rate_hz)
    gains = [parameters[joint][Parameter.KP] for joint in JOINTS]
    return gains, parameters[1][Parameter.NATURAL_FREQUENCY]


def _math(settings: Settings, law: ControlLaw) -> MathProcessor:
    arm = arm_by_name(settings.arm)
    return MathProcessor(arm, make_dynamics(arm, "full"), law, *_gains(settings))


def _c_theta(law: ControlLaw, settings: Settings) -> float:
    arm = arm_by_name(settings.arm)
    model = make_dynamics(arm, "full")
    model.update(_joints(settings))
    gains, natural = _gains(settings)
    frame = Transform.translation(0.0, 0.0, 0.1)
    J, M = model.J, model.M
    begun = compliance_jacobian(J, frame)
    rows = LAWS[law].begin(begun, M, COMPLIES, Servos(gains, natural, arm.a2))
    return least(settings, lambda: rows(compliance_jacobian(J, frame), M), 8)


def _background(settings: Settings) -> float:
    math = _math(settings, ControlLaw.HYBRID)
    compliance = Compliance().changed(COMPLIES, Transform.translation(0.0, 0.0, 0.1))
    q = _joints(settings)
    return 1.0 / least(settings, lambda: math.rows(1, q, compliance, NOTHING), 8)


# --- whole nodes, and what carries their frames ---------------------------------------------------


class NodeTimes(NamedTuple):
    """Seconds a cycle: of the master, and of the dearest joint node."""

    master: float
    joint: float


@cache
def node_times(settings: Settings) -> NodeTimes:
    """Of the whole loop on the simulated bus, the arm moving to and fro.

    Medians over the cycles of a batch, the least of all batches: one interruption spoils a cycle,
    and would spoil the mean of a batch.
    """
    session = loop(min(100, settings.cycles), RunSettings(arm=settings.arm, rate=settings.rate_hz))
    keep_moving(session)
    rig = session.rig
    assert isinstance(rig, SimulatedRig)
    nodes = (rig.master, *rig.joints)
    spent = [0.0] * len(nodes)
    clock = time.perf_counter

    def timed(number: int, call: Callable[..., object]) -> Callable[..., object]:
        def wrapper(*args: object) -> object:
            began = clock()
            answer = call(*args)
            spent[number] += clock() - began
            return answer

        return wrapper

    for number, node in enumerate(nodes):
        for method in ("on_frame", "on_time"):
            setattr(node, method, timed(number, getattr(node, method)))
    rig.bus.reroute()
    batches: list[NodeTimes] = []
    for _ in range(max(1, min(settings.batches // 4, MOVING_CYCLES // settings.cycles))):
        cycles: list[list[float]] = []
        for _ in range(settings.cycles):
            spent[:] = [0.0] * len(nodes)
            run(session, 1)
            cycles.append(list(spent))
        master, *joints = np.median(cycles, axis=0).tolist()
        batches.append(NodeTimes(master, max(joints)))
    return NodeTimes(min(b.master for b in batches), min(b.joint for b in batches))


def _bus(settings: Settings) -> float:
    return settings.rate_hz / budget(settings.rate_hz, BusTiming(), cycle=Cycle.USUAL).load


def _network(settings: Settings) -> float:
    """Ten clients send at once; in a directory of its own, so that no other server is met."""
    message, name = bytes(MESSAGE_BYTES), "bench-thesis"
    before = os.environ.get("XDG_RUNTIME_DIR")
    with ExitStack() as stack:
        directory = stack.enter_context(tempfile.TemporaryDirectory(prefix="rfms-"))
        os.environ["XDG_RUNTIME_DIR"] = directory
        try:
            server = stack.enter_context(ServerSocket(name))
            clients = [stack.enter_context(ClientSocket(name)) for _ in range(COMPONENTS)]
        finally:
            if before is None:
                del os.environ["XDG_RUNTIME_DIR"]
            else:
                os.environ["XDG_RUNTIME_DIR"] = before

        def exchange() -> None:
            for client in clients:
                client.send(message)
            arrived = 0
            while arrived < COMPONENTS:
                server.wait(1.0)
                arrived += sum(1 for _ in server.requests())

        return least(settings, exchange, 20)


def _network_can(settings: Settings) -> float:
    length = next(length for length in FD_DLC_LENGTHS if length >= MESSAGE_BYTES)
    return COMPONENTS * BusTiming().worst_case_ns(length) / NS_PER_S


MEASURES: Final[Mapping[str, Callable[[Settings], float]]] = {
    "t6": _t6,
    "drive": _drive,
    "drive_whole": _drive_whole,
    **{f"inverse_{joint}": partial(_inverse, joint) for joint in JOINTS},
    "torque": _torque,
    "joint": lambda settings: node_times(settings).joint,
    "setpoint": _setpoint,
    "rccl": _rccl,
    "dynamics_full": partial(_dynamics, "full"),
    "dynamics_simplified": partial(_dynamics, "simplified"),
    "c_hybrid": partial(_c_theta, ControlLaw.HYBRID),
    "c_stiffness": partial(_c_theta, ControlLaw.STIFFNESS),
    "c_free_joint": partial(_c_theta, ControlLaw.FREE_JOINT),
    "background": _background,
    "serial": lambda settings: 1.0 / sum(node_times(settings)),
    "pipelined": lambda settings: 1.0 / max(node_times(settings)),
    "bus": _bus,
    "network": _network,
    "network_can": _network_can,
}
"""What each figure is here, s or Hz."""


def measure(settings: Settings, figures: Sequence[Figure] = FIGURES) -> list[Row]:
    """All figures, in the order of the table."""
    best: list[Row] = []
    for _ in range(settings.rounds):
        node_times.cache_clear()
        rows = [Row(figure, MEASURES[figure.key](settings)) for figure in figures]
        best = [
            max(pair, key=lambda row: row.ratio) for pair in zip(best or rows, rows, strict=True)
        ]
    return best
