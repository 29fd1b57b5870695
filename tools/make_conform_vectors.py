"""Write the numbers that ``rfms conform`` holds a node to: ``rfms_can/conform/vectors/*.json``.

What a node must compute is computed by the third node (``third_node/README.md``), which knows
nothing of ours; what is asked of it (poses, parameters of arms) comes from our arms.
``rfms_can/conform/vectors/README.md`` has the format.
"""

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import conform_edge_traces
import conform_law_traces
import conform_life_traces
import conform_poses
import conform_setpoint_traces
import conform_stop_traces
from conform_poses import told
from conform_record import recorded
from third_node import kinematics
from third_node.codec import float32
from third_node.configuration import NUMBER, TABLE, Geometry, hash_of

from rfms_can.arm import ARMS, PUMA_260, Arm
from rfms_can.kinematics import configuration_of, direct
from rfms_can.master.start_up.node_parameters import all_parameters
from rfms_can.transform import Transform
from rfms_can.wire.configuration import DhRow, geometry_values
from rfms_can.wire.nodes import JOINTS

VECTORS: Final = Path(__file__).resolve().parents[1] / "rfms_can" / "conform" / "vectors"
PERIOD_S: Final = 0.004
SEED: Final = 1986
POSES: Final = 24
"""Random poses of each arm; each is asked in all eight configurations."""

BENCH: Final = {
    "ARM_ID": 260.0,
    "PERIOD": PERIOD_S,
    "KP": 50.0,
    "KI": 400.0,
    "KD": 5.0,
    "INTEGRAL_LIMIT": 3.0,
    "INTEGRAL_DEADBAND": 2e-4,
    "NATURAL_FREQUENCY": 25.0,
    "DAMPING_RATIO": 0.75,
    "TORQUE_LIMIT": 10.0,
    "TORQUE_PER_CODE": 0.006,
    "COUNTS_PER_UNIT": 8000.0,
    "RATE_PER_CODE": 0.002,
    "COULOMB_POSITIVE": 0.8,
    "COULOMB_NEGATIVE": 0.6,
    "VISCOUS": 0.3,
    "FRICTION_SPEED": 0.01,
    "POSITION_MIN": -2.5,
    "POSITION_MAX": 2.75,
    "SPEED_LIMIT": 2.0,
    "ACCELERATION_LIMIT": 8.0,
    "COARSE_PER_CODE": 0.0015,
    "COARSE_ZERO": -3.0,
    "INDEX_INTERVAL_COUNTS": 1000.0,
    "HOMING_SPEED": 0.4,
    "DITHER_FRACTION": 0.0,
    "DITHER_PERIOD": 0.024,
    "TORQUE_PER_FORCE_CODE": 0.004,
    "CLOCK": 0.0,
    "BARRIER": 2.0,
    "SENSOR_SOURCE": 9.0,
    "KINEMATICS": 1.0,
    "FOLLOWING_ERROR_LIMIT": 0.2,
    "OVERSPEED_LIMIT": 3.0,
    "TACHOMETER_LIMIT": 2.0,
    "CONTINUOUS_TORQUE": 6.0,
    "OVERLOAD_TIME": 5.0,
    "STALL_TIME": 0.5,
    "STUCK_TIME": 0.1,
    "HOMING_TIME": 3.0,
    "CURRENT_TOLERANCE": 0.035,
    "RATE_ERROR_LIMIT": 0.5,
}
"""A joint that no arm has, so that the law is the same for all six; the 260's geometry."""


TRACES: Final = {
    "laws": conform_law_traces.traces,
    "setpoints": conform_setpoint_traces.traces,
    "stops": conform_stop_traces.traces,
    "edges": conform_edge_traces.traces,
    "lives": conform_life_traces.traces,
}
"""Files of traces, and what is played."""


REST: Final = (0.3, 0.9, -2.4, 0.4, -0.9, 0.5)
"""Angles of the bench's pose at rest, rad."""


def main() -> None:
    """Write all files."""
    VECTORS.mkdir(exist_ok=True)
    for file, make in FILES.items():
        write(file, make())
    for file in TRACES:
        write(file, traced(file))


def traced(file: str) -> Any:
    """The traces of a file, as they are recorded."""
    torques, registers = file != "setpoints", file == "lives"
    return {"traces": recorded(TRACES[file](), torques=torques, registers=registers)}


def write(name: str, content: Any) -> None:
    """One file."""
    (VECTORS / f"{name}.json").write_text(text_of(content), encoding="utf-8")


def text_of(content: Any) -> str:
    """A file: a line for each entry of the outermost list or table."""
    text = json.dumps(content, separators=(",", ":"))
    for opening in ('{"o":', '{"name":', '{"cycle":'):
        text = text.replace(opening, "\n" + opening)
    return text + "\n"


def bench_parameters() -> dict[str, float]:
    """The bench's parameters, in float32."""
    links = tuple(DhRow(a, d, alpha) for alpha, a, d in PUMA_260.dh)
    geometry = {p.name: v for p, v in geometry_values(links).items()}
    return {name: float32(value) for name, value in {**BENCH, **geometry}.items()}


def bench() -> dict[str, Any]:
    """The bench: parameters, and a pose at rest."""
    rest = solved(PUMA_260, direct(PUMA_260, REST), configuration_of(PUMA_260, REST).code)
    return {"parameters": bench_parameters(), "rest": rest}


def parameters(arm: Arm) -> dict[str, dict[str, float]]:
    """What each joint of an arm is told."""
    nodes = all_parameters(arm, "corke", PERIOD_S)
    return {str(j): {p.name: v for p, v in nodes[j].items()} for j in JOINTS}


def inverse(arm: Arm) -> list[dict[str, Any]]:
    """Random poses in every configuration, and some that the arm cannot take."""
    draw = random.Random(SEED)
    poses: list[Transform] = []
    for _ in range(POSES):
        poses.append(direct(arm, [draw.uniform(*limits) for limits in arm.joint_limits]))
    reach = arm.a2 + arm.d4
    poses.append(poses[0]._replace(px=reach, py=0.3 * reach, pz=0.1))
    poses.append(poses[1]._replace(px=0.5 * arm.shoulder_offset, py=0.0, pz=0.2))
    return [solved(arm, pose, code) for pose in poses for code in range(8)]


def solved(arm: Arm, pose: Transform, code: int) -> dict[str, Any]:
    """The angles of a pose, each on the turn nearest to 0; null where a joint has none."""
    entry = told(pose, code)
    values = parameters(arm)["1"]
    geometry = Geometry({NUMBER[name]: value for name, value in values.items()})
    angles = []
    for joint, limits in zip(JOINTS, arm.joint_limits, strict=True):
        parts = (entry["o"], entry["a"], entry["p"])
        angle = kinematics.solve(joint, geometry, *parts, code, kinematics.Held())
        angles.append(None if angle is None else kinematics.nearest_turn(angle, 0.0, *limits))
    return {**entry, "angles": angles}


STRAIGHT: Final = ((0.3, 0.7, 0.4, 0.5), (-0.4, 1.1, -0.8, -1.2), (0.9, 0.4, 1.3, 0.2))
"""Straight wrists of the 260: joints 1, 2, 4 and 6, rad; joint 3 is -2."""


def straight(q1: float, q2: float, q4: float, q6: float) -> dict[str, Any]:
    """A pose with joint 5 at 0, where joint 4 is told, and one before it that is regular."""
    q = (q1, q2, -2.0, q4, 0.0, q6)
    bent = (q1, q2, -2.0, q4, 0.4, q6)
    code = configuration_of(PUMA_260, bent).code
    return {
        **told(direct(PUMA_260, q), code),
        "angles": list(q),
        "bent": {**told(direct(PUMA_260, bent), code), "angles": list(bent)},
    }


TURN_STEP: Final = 0.75
"""Between the poses of a joint that turns, rad."""


def turning(joint: int) -> list[dict[str, Any]]:
    """Poses of the 260 with one joint turning on, and its angle, over more than a turn."""
    poses = []
    for k in range(11):
        q = list(REST)
        q[joint - 1] += TURN_STEP * k - 3.1
        code = configuration_of(PUMA_260, q).code
        poses.append({**told(direct(PUMA_260, q), code), "angle": q[joint - 1]})
    return poses


def hashes() -> list[dict[str, Any]]:
    """Sets of parameters and their hashes."""
    sets = [bench_parameters()]
    sets += [parameters(arm)[str(j)] for arm in ARMS.values() for j in (1, 4)]
    return [
        {
            "name": f"set {n}",
            "parameters": s,
            "hash": hash_of({NUMBER[k]: v for k, v in s.items()}),
        }
        for n, s in enumerate(sets, 1)
    ]


def ranges() -> dict[str, dict[str, Any]]:
    """What each parameter may be: the table of docs/wire.md, bounds in float32."""
    return {
        name: {
            "low": float32(low),
            "high": float32(high),
            "signed": kind == "magnitude",
            "whole": kind == "whole",
        }
        for name, low, high, kind in TABLE.values()
    }


FILES: Final[dict[str, Callable[[], Any]]] = {
    "bench": bench,
    "arms": lambda: {arm.name: parameters(arm) for arm in ARMS.values()},
    "inverse": lambda: {arm.name: inverse(arm) for arm in ARMS.values()},
    "straight": lambda: [straight(*case) for case in STRAIGHT],
    "turns": lambda: {str(joint): turning(joint) for joint in JOINTS},
    "shapes": conform_poses.shapes,
    "wrists": conform_poses.wrists,
    "ends": lambda: conform_poses.ends(REST, BENCH["POSITION_MIN"], BENCH["POSITION_MAX"]),
    "hashes": hashes,
    "ranges": ranges,
}
"""Files of numbers, and what makes them."""


if __name__ == "__main__":
    main()
