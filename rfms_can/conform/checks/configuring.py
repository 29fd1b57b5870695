"""Checks 12 to 19: the configuration, parameter by parameter and as a set."""

import binascii
import struct
from typing import Any, Final

from rfms_can.conform.tester import Parameters, Tester
from rfms_can.conform.vectors import float32, read, set_hash
from rfms_can.wire.nodes import JOINTS
from rfms_can.wire.records import Config, ConfigAck
from rfms_can.wire.vocabulary import Command, ConfigStatus, NodeState, Parameter

P = Parameter

UNKNOWN: Final = (42, 63, 88, 100, 191, 192, 254)
"""Numbers that contract 2.0 has no name for."""
LARGEST: Final = 1e9
"""Greatest value that CONFIG carries."""
CONTRADICTIONS: Final = (
    (P.POSITION_MIN, P.POSITION_MAX, 1.0),
    (P.INTEGRAL_LIMIT, P.TORQUE_LIMIT, 1.0),
    (P.CONTINUOUS_TORQUE, P.TORQUE_LIMIT, 1.0),
    (P.HOMING_SPEED, P.SPEED_LIMIT, 1.0),
    (P.OVERSPEED_LIMIT, P.SPEED_LIMIT, 1.5),
    (P.TACHOMETER_LIMIT, P.SPEED_LIMIT, 1.0),
)
"""The first must not be greater than so many times the second."""
OPTIONAL: Final = (P.CURRENT_TOLERANCE, P.RATE_ERROR_LIMIT)
"""What a master may leave out: a node has a value of its own for it."""
UNSUPPORTED: Final[tuple[tuple[Parameter, float], ...]] = (
    (P.KINEMATICS, 2.0),
    (P.KINEMATICS, 15.0),
    (P.DH_ALPHA_1, 0.0),
    (P.DH_ALPHA_1, -900000.0),
    (P.DH_ALPHA_2, 900000.0),
    (P.DH_ALPHA_4, 900001.0),
    (P.DH_OFFSET_1, 900000.0),
    (P.DH_OFFSET_6, 1.0),
    (P.DH_A_1, 1.0),
    (P.DH_D_1, 1.0),
    (P.DH_A_4, 1.0),
    (P.DH_A_6, -1.0),
    (P.DH_D_5, 1.0),
    (P.DH_D_6, 100000.0),
    (P.DH_A_2, 0.0),
    (P.DH_A_2, -203200.0),
    (P.DH_D_4, 0.0),
    (P.DH_D_4, -203200.0),
)
"""What the closed form cannot do."""


def send(t: Tester, parameter: int, value: float) -> ConfigAck:
    """One parameter; the answer, which repeats number and value, and no hash."""
    ack: ConfigAck = t.one(t.say(Config, t.joint, parameter, 0, value, 0), "CONFIG_ACK")
    t.equal(ack.parameter, parameter, "parameter in CONFIG_ACK")
    t.equal(ack.value, float32(value), f"value of parameter {parameter} in CONFIG_ACK")
    t.equal(ack.hash, 0, "hash in the answer to a parameter")
    return ack


def status(t: Tester, ack: ConfigAck, want: ConfigStatus, why: str) -> None:
    """The answer must be this one."""
    t.equal(ConfigStatus(ack.status).name, want.name, why)


def send_all(t: Tester, values: Parameters) -> None:
    """All parameters, which are all taken."""
    t.parameters = values
    for parameter, value in values.items():
        status(t, send(t, parameter, value), ConfigStatus.TAKEN, parameter.name)


def held(t: Tester) -> int:
    """Hash in the node's HEARTBEAT."""
    return t.state_is(NodeState.PREOP).config_hash


def committed(t: Tester, want: ConfigStatus, why: str, **told: int) -> None:
    """COMMIT: the answer, its hash, and what the node holds then."""
    digest = set_hash(t.parameters)
    ack = t.commit(**told)
    status(t, ack, want, f"COMMIT {why}")
    t.equal(ack.parameter, P.COMMIT, "parameter in CONFIG_ACK")
    t.equal(ack.hash, digest, f"hash in the answer to COMMIT {why}")
    t.equal(held(t), digest if want is ConfigStatus.TAKEN else 0, f"hash held after COMMIT {why}")


def each_parameter(t: Tester) -> None:
    """Each is taken, and its value repeated bit for bit."""
    t.to_preop()
    send_all(t, t.bench())
    t.equal(held(t), 0, "hash before COMMIT")
    committed(t, ConfigStatus.TAKEN, "of the bench")
    committed(t, ConfigStatus.TAKEN, "that repeats the set in force")
    for sets in read("hashes"):
        t.to_preop()
        values = {Parameter[name]: value for name, value in sets["parameters"].items()}
        send_all(t, values)
        committed(t, ConfigStatus.TAKEN, f"of {sets['name']}")
        t.equal(held(t), sets["hash"], f"hash of {sets['name']}")


def ranges(t: Tester) -> None:
    """The ends of each range are taken, the next float32 beyond them is not."""
    t.to_preop()
    bench = t.bench()
    send_all(t, bench)
    for name, told in read("ranges").items():
        parameter = Parameter[name]
        for value in _inside(told):
            status(t, send(t, parameter, value), ConfigStatus.TAKEN, f"{name} {value:g}")
        status(t, send(t, parameter, bench[parameter]), ConfigStatus.TAKEN, name)
        for value in _outside(told):
            ack = send(t, parameter, value)
            status(t, ack, ConfigStatus.REFUSED_VALUE, f"{name} {value:.9g}")
    # a value that was refused is not kept: the set is as it was
    committed(t, ConfigStatus.TAKEN, "after values that were refused")


def _inside(told: dict[str, Any]) -> list[float]:
    low, high = told["low"], told["high"]
    return [low, high, *((-low, -high) if told["signed"] else ())]


def _outside(told: dict[str, Any]) -> list[float]:
    """Values just beyond a range, as far as CONFIG can say them."""
    return [value for value in _beyond(told) if abs(value) <= LARGEST]


def _beyond(told: dict[str, Any]) -> list[float]:
    low, high = told["low"], told["high"]
    if told["whole"]:
        step = 2.0 if high >= 2.0**24 else 1.0
        return [low - (2.0 if low <= -(2.0**24) else 1.0), high + step, 1.5]
    outside = [_next(high, 1)]
    if told["signed"]:
        return [*outside, -outside[0], _next(low, -1), -_next(low, -1), 0.0]
    return [*outside, _next(low, -1)]


def _next(value: float, direction: int) -> float:
    """The float32 number after a value, upwards or downwards."""
    if value == 0.0:
        return direction * 2.0**-149
    (bits,) = struct.unpack("<i", struct.pack("<f", value))
    away = 1 if (value > 0.0) == (direction > 0) else -1
    following: float = struct.unpack("<f", struct.pack("<i", bits + away))[0]
    return following


def unknown(t: Tester) -> None:
    """Numbers without a name: told so, and not part of the set."""
    t.to_preop()
    send_all(t, t.bench())
    for number in UNKNOWN:
        status(t, send(t, number, 1.5), ConfigStatus.UNKNOWN, f"parameter {number}")
    committed(t, ConfigStatus.TAKEN, "after unknown parameters")
    digest = held(t)
    status(t, send(t, UNKNOWN[0], 2.5), ConfigStatus.UNKNOWN, "parameter 42 after COMMIT")
    t.equal(held(t), digest, "hash held after an unknown parameter")


def wrong_commit(t: Tester) -> None:
    """Another hash, another number, and sets that lack one."""
    bench = t.bench()
    digest = set_hash(bench)
    for told in (
        {"digest": digest ^ 1},
        {"digest": 0},
        {"total": len(bench) - 1},
        {"total": len(bench) + 1},
        {"total": 0},
    ):
        t.to_preop()
        send_all(t, bench)
        committed(t, ConfigStatus.WRONG_HASH, f"with {told}", **told)
        t.only(t.command(Command.HOME), ())
        t.state_is(NodeState.PREOP)
    for left_out in (P.ARM_ID, P.KP, P.TORQUE_PER_FORCE_CODE, P.HOMING_TIME, P.DH_OFFSET_6):
        t.to_preop()
        send_all(t, {p: v for p, v in bench.items() if p is not left_out})
        committed(t, ConfigStatus.WRONG_HASH, f"without {left_out.name}")
    t.to_preop()
    send_all(t, {P.KP: 1.0})
    committed(t, ConfigStatus.WRONG_HASH, "of one parameter, after a set that was refused")


def in_any_order(t: Tester) -> None:
    """The hash is that of ascending numbers; the last of two values counts; two are not hashed."""
    t.to_preop()
    bench = t.bench()
    status(t, send(t, P.KP, 1.0), ConfigStatus.TAKEN, "KP")
    send_all(t, dict(reversed(bench.items())))
    committed(t, ConfigStatus.TAKEN, "in reversed order, KP twice")
    t.equal(held(t), set_hash(bench), "hash")
    t.to_preop()
    send_all(t, {**bench, P.CLOCK: 2.0, P.BARRIER: 77.0})
    committed(t, ConfigStatus.TAKEN, "with another CLOCK and BARRIER")
    t.equal(held(t), set_hash(bench), "hash")
    t.to_preop()
    other = {**bench, P.KP: float32(50.001)}
    send_all(t, other)
    committed(t, ConfigStatus.TAKEN, "with another KP")
    if set_hash(other) == set_hash(bench):
        t.fail("the same hash", "another hash with another KP")
    t.to_preop()
    send_all(t, _whose_crc_is_0(bench))
    committed(t, ConfigStatus.TAKEN, "of a set whose CRC is 0: its hash is 1")


def _whose_crc_is_0(bench: Parameters) -> Parameters:
    """The bench with an ARM_ID that makes the CRC 0, which stands for no configuration."""
    hashed = sorted(p for p in bench if p not in (P.CLOCK, P.BARRIER))
    assert hashed[0] is P.ARM_ID
    rest = b"".join(struct.pack("<Bf", p, bench[p]) for p in hashed[1:])
    for number in range(1 << 24):
        if binascii.crc_hqx(struct.pack("<Bf", P.ARM_ID, number) + rest, 0xFFFF) == 0:
            return {**bench, P.ARM_ID: float(number)}
    raise AssertionError("no ARM_ID makes the CRC 0")


def after_commit(t: Tester) -> None:
    """A parameter voids the set in force and begins an empty one."""
    t.to_preop()
    bench = t.bench()
    send_all(t, bench)
    committed(t, ConfigStatus.TAKEN, "")
    status(t, send(t, P.KP, bench[P.KP]), ConfigStatus.TAKEN, "KP after COMMIT")
    t.equal(held(t), 0, "hash after a parameter")
    t.only(t.command(Command.HOME), ())
    t.state_is(NodeState.PREOP)
    t.parameters = {P.KP: bench[P.KP]}
    committed(t, ConfigStatus.WRONG_HASH, "of the one parameter")
    send_all(t, bench)
    committed(t, ConfigStatus.TAKEN, "of the whole set again")


def reset_and_configuration(t: Tester) -> None:
    """RESET keeps a set in force, and clears one that was not closed."""
    t.to_preop()
    bench = t.bench()
    send_all(t, bench)
    committed(t, ConfigStatus.TAKEN, "")
    t.only(t.command(Command.RESET), ())
    t.equal(held(t), set_hash(bench), "hash after RESET")
    committed(t, ConfigStatus.TAKEN, "again after RESET")
    half = len(bench) // 2
    send_all(t, dict(list(bench.items())[:half]))
    t.only(t.command(Command.RESET), ())
    send_all(t, dict(list(bench.items())[half:]))
    committed(t, ConfigStatus.WRONG_HASH, "of the half that came after RESET")


def impossible(t: Tester) -> None:
    """Sets that contradict themselves, or ask for what a node does not have."""
    bench = t.bench()
    for lesser, greater, times in CONTRADICTIONS:
        bound = times * bench[greater]
        for value, want in (
            (bound, ConfigStatus.TAKEN),
            (float32(bound * 1.001), ConfigStatus.REFUSED_VALUE),
        ):
            t.to_preop()
            send_all(t, {**bench, lesser: value})
            committed(t, want, f"with {lesser.name} {value:.9g}, {greater.name} {bench[greater]:g}")
    for left_out in ((OPTIONAL[0],), (OPTIONAL[1],), OPTIONAL):
        t.to_preop()
        send_all(t, {p: v for p, v in bench.items() if p not in left_out})
        committed(t, ConfigStatus.TAKEN, f"without {', '.join(p.name for p in left_out)}")
    for parameter, value in UNSUPPORTED:
        t.to_preop()
        send_all(t, {**bench, parameter: value})
        committed(t, ConfigStatus.UNSUPPORTED, f"with {parameter.name} {value:g}")
    boards = {10 + joint for joint in JOINTS}
    for source in (9, *sorted(boards), 1 + t.joint % 6, 7, 8, 10, 17, 31):
        t.to_preop()
        send_all(t, {**bench, P.SENSOR_SOURCE: float(source)})
        fits = source in (9, 10 + t.joint)
        want = ConfigStatus.TAKEN if fits else ConfigStatus.UNSUPPORTED
        committed(t, want, f"with SENSOR_SOURCE {source}")
    t.to_preop()
    send_all(t, {**bench, P.KINEMATICS: 0.0, P.DH_ALPHA_1: 0.0, P.DH_A_2: 0.0})
    committed(t, ConfigStatus.TAKEN, "with KINEMATICS 0 and no closed form")
    for parameter, value in ((P.PERIOD, 0.0), (P.PERIOD, -1.0)):
        ack = send(t, parameter, value)
        status(t, ack, ConfigStatus.REFUSED_VALUE, f"{parameter.name} {value:g}")


def refused_by_state(t: Tester) -> None:
    """Only PREOP takes a parameter; elsewhere the node says so and goes on."""

    def refuses() -> None:
        before = t.beat()
        for parameter in (P.KP, P.COMMIT, UNKNOWN[0]):
            ack = send(t, parameter, 7.0) if parameter != P.COMMIT else t.commit()
            status(t, ack, ConfigStatus.REFUSED_STATE, f"in {NodeState(before.state).name}")
            t.equal(ack.hash, 0, "hash")
        after = t.beat()
        t.equal(
            (after.state, after.config_hash), (before.state, before.config_hash), "state and hash"
        )

    t.configure()
    t.only(t.command(Command.HOME), ())
    t.state_is(NodeState.HOMING)
    refuses()
    t.ready()
    refuses()
    t.operational()
    t.run(2)
    refuses()
    t.only(t.run(), ("ERROR", "DAC"), "it goes on")
    t.command(Command.QUICKSTOP)
    t.state_is(NodeState.QUICKSTOP)
    refuses()
    t.estop()
    t.state_is(NodeState.FAULT)
    refuses()
