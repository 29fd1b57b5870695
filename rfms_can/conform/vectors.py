"""What a node must compute, from files of numbers that no code of the node's made here.

``vectors/README.md`` says what stands in each file. All is SI and radians.
"""

import binascii
import json
import struct
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any, Final, NamedTuple

from rfms_can.wire.vocabulary import Parameter

_FLOAT: Final = struct.Struct("<f")
_PAIR: Final = struct.Struct("<Bf")
_UNHASHED: Final = (Parameter.CLOCK, Parameter.BARRIER)


def float32(value: float) -> float:
    """A number as CONFIG and SETPOINT carry it."""
    rounded: float = _FLOAT.unpack(_FLOAT.pack(value))[0]
    return rounded


def set_hash(values: Mapping[Parameter, float]) -> int:
    """Hash of a set of parameters; ``vectors/hashes.json`` has sets and their hashes."""
    pairs = (_PAIR.pack(p, values[p]) for p in sorted(values) if p not in _UNHASHED)
    return binascii.crc_hqx(b"".join(pairs), 0xFFFF) or 1


class Pose(NamedTuple):
    """A pose in SETPOINT: o and a of T6, the wrist centre p, m, and its branch."""

    o: tuple[float, ...]
    a: tuple[float, ...]
    p: tuple[float, ...]
    configuration: int

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> "Pose":
        """From a vector file."""
        o, a, p = (tuple(map(float, told[name])) for name in ("o", "a", "p"))
        return cls(o, a, p, int(told["configuration"]))


class Vectors:
    """All vector files.

    Attributes:
        bench: parameters of the suite's bench.
        rest_pose: a pose that the bench's arm can take.
        rest_angles: the six angles of it, rad.
        arms: parameters of each joint of each arm: name, then joint.
        inverse: poses of each arm, with the six angles; null where there is no solution.
        traces: set-points and laws, cycle by cycle, by file.
    """

    def __init__(self) -> None:
        bench = read("bench")
        self.bench = named(bench["parameters"])
        self.rest_pose = Pose.of(bench["rest"])
        self.rest_angles = tuple(map(float, bench["rest"]["angles"]))
        self.arms: dict[str, dict[int, dict[Parameter, float]]] = {
            arm: {int(joint): named(values) for joint, values in joints.items()}
            for arm, joints in read("arms").items()
        }
        self.inverse: dict[str, list[dict[str, Any]]] = read("inverse")

    def traces(self, file: str) -> list[dict[str, Any]]:
        """The traces of a file."""
        traces: list[dict[str, Any]] = read(file)["traces"]
        return traces


def named(values: Mapping[str, float]) -> dict[Parameter, float]:
    """Parameters by name to parameters."""
    return {Parameter[name]: float(value) for name, value in values.items()}


@cache
def read(name: str) -> Any:
    """A vector file."""
    path = resources.files("rfms_can.conform") / "vectors" / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8"))
