"""Tables of the configuration: its parameters, its hash, and the answers to CONFIG."""

from typing import Final

from generated import table

from node_book.printed import float32_hex, number
from node_book.pump import JOINT, Pump, parameters
from rfms_can.tables import complete
from rfms_can.wire.configuration import PARAMETERS, UNHASHED, configuration_hash
from rfms_can.wire.frame import Frame
from rfms_can.wire.records import Config
from rfms_can.wire.vocabulary import ConfigStatus, Parameter

P = Parameter

_DH: Final = {
    "DH_A": "a of link {0}",
    "DH_D": "d of link {0}",
    "DH_ALPHA": "alpha of link {0}",
    "DH_OFFSET": "offset of the zero of joint {0}",
}
MEANINGS: Final[dict[Parameter, str]] = complete(
    {
        P.ARM_ID: "a name of the arm; a node only repeats it in the hash: any is taken",
        P.PERIOD: "tau: time from SYNC to SYNC",
        P.KP: "gain of the PID",
        P.KI: "gain of the integral",
        P.KD: "gain of the derivative",
        P.INTEGRAL_LIMIT: "bound of the integral torque",
        P.INTEGRAL_DEADBAND: "error that a rigid joint does not integrate",
        P.NATURAL_FREQUENCY: "wn of the weighted law",
        P.DAMPING_RATIO: "zeta of the weighted law",
        P.TORQUE_LIMIT: "bound of the joint's whole torque",
        P.TORQUE_PER_CODE: "of current_dac; negative where the motor turns against the joint",
        P.COUNTS_PER_UNIT: "encoder counts per rad; either sign",
        P.RATE_PER_CODE: "of velocity_adc; either sign",
        P.COULOMB_POSITIVE: "friction of motion to larger angles",
        P.COULOMB_NEGATIVE: "friction of motion to smaller angles, as a positive number",
        P.VISCOUS: "friction per speed",
        P.FRICTION_SPEED: "commanded speed up to which a rigid joint counts as resting",
        P.POSITION_MIN: "lower end of the range",
        P.POSITION_MAX: "upper end of the range",
        P.SPEED_LIMIT: "of the joint; 1.5 times as fast is a step",
        P.ACCELERATION_LIMIT: "deceleration of a controlled stop",
        P.COARSE_PER_CODE: "of coarse_adc",
        P.COARSE_ZERO: "joint angle at coarse_adc 0",
        P.INDEX_INTERVAL_COUNTS: "counts from index pulse to index pulse",
        P.HOMING_SPEED: "of the search for the index",
        P.DITHER_FRACTION: "of the friction; 0: no dither",
        P.DITHER_PERIOD: "of the dither's square wave",
        P.TORQUE_PER_FORCE_CODE: "of force_dac",
        P.CLOCK: "0 virtual, 1 lockstep, 2 realtime: whose period the watchdog of SYNC takes",
        P.BARRIER: "longest cycle in lockstep",
        P.SENSOR_SOURCE: "node number of who sends MEASURE and REFERENCE",
        P.KINEMATICS: "0: the master solves; 1: closed form of a spherical wrist",
        P.FOLLOWING_ERROR_LIMIT: "largest error of a rigid joint; half of it may be a runaway's",
        P.OVERSPEED_LIMIT: "measured speed that is too fast; at most 1.5 SPEED_LIMIT",
        P.TACHOMETER_LIMIT: "difference of tachometer and encoder that is found in three cycles",
        P.CONTINUOUS_TORQUE: "torque that the motor bears for ever",
        P.OVERLOAD_TIME: "how long it bears TORQUE_LIMIT",
        P.STALL_TIME: "longest stand of a joint that is driven at its torque limit",
        P.STUCK_TIME: "longest stand of an encoder while homing is at its torque limit",
        P.HOMING_TIME: "longest search for the index",
        P.CURRENT_TOLERANCE: "of current_adc against the DACs, over full scale",
        P.RATE_ERROR_LIMIT: "error of a rigid joint's rate, over SPEED_LIMIT",
        **{
            p: text.format(p.name.rpartition("_")[2])
            for p in Parameter
            for head, text in _DH.items()
            if p.name.rpartition("_")[0] == head
        },
    },
    PARAMETERS,
)
"""What each parameter is."""


def parameters_of_a_joint() -> str:
    """The configuration of the pages' joint, which is the vector of the hash too."""
    rows = []
    for parameter, value in sorted(parameters().items()):
        known = PARAMETERS[parameter]
        span = f"{'magnitude ' if known.signed else ''}{known.low:.9g} to {known.high:.9g}"
        whole = ", whole" if known.whole else ""
        unit = "1/rad" if known.unit == "1/u" else "rad" if known.unit == "u" else known.unit
        rows.append(
            (
                *(str(int(parameter)), parameter.name, unit, span + whole, MEANINGS[parameter]),
                *(f"`{float32_hex(value)}`", number(value, 9)),
            )
        )
    return table(("number", "parameter", "unit", "range", "what", "bytes", "value"), rows)


def hashed_bytes(values: dict[Parameter, float]) -> bytes:
    """What the CRC of a configuration runs over."""
    pairs = [(p, v) for p, v in sorted(values.items()) if p not in UNHASHED]
    return b"".join(bytes([p]) + bytes.fromhex(float32_hex(v)) for p, v in pairs)


def hashes() -> str:
    """Vectors of the configuration hash."""
    small = {P.PERIOD: 0.004, P.ARM_ID: 260.0}
    sets = (
        ("ARM_ID 260, PERIOD 0.004", small),
        ("the same with CLOCK 2, BARRIER 2", {**small, P.CLOCK: 2.0, P.BARRIER: 2.0}),
        ("all of the table above", parameters()),
    )
    rows = []
    for words, values in sets:
        data = hashed_bytes(values)
        shown = f"`{data.hex(' ').upper()}`" if len(data) < 20 else f"{len(data)} bytes"
        rows.append((words, shown, f"0x{configuration_hash(values):04X}"))
    return table(("set", "bytes", "hash"), rows)


Step = tuple[str, Parameter | int, float, int | None]


class Dialogue:
    """Sends CONFIG to a joint and notes its answers.

    Attributes:
        rows: of the table.
    """

    def __init__(self) -> None:
        self.pump = Pump()
        self.rows: list[tuple[str, ...]] = []

    def say(
        self, words: str, parameter: int, value: float, total: int = 0, digest: int = 0
    ) -> None:
        """One CONFIG and its answer."""
        answers = self.pump.say(Config, JOINT, parameter, total, value, digest)
        self.note(words, answers)

    def note(self, words: str, answers: list[Frame]) -> None:
        """A row."""
        if not answers:
            self.rows.append((words, "no answer; discarded + 1", "", ""))
            return
        ack = next(c for c in self.pump.wire.codecs.values() if c.id == answers[0].id).unpack(
            answers[0].data
        )
        status = ConfigStatus(ack.status).name  # type: ignore[union-attr]
        told = f"0x{ack.hash:04X}" if ack.parameter == P.COMMIT else ""  # type: ignore[union-attr]
        self.rows.append((words, status, told, f"0x{self.pump.node.config_hash:04X}"))

    def whole(
        self, changes: dict[Parameter, float] | None = None, without: Parameter | None = None
    ) -> dict[Parameter, float]:
        """All parameters, or all but one, without a row."""
        values = {**parameters(), **(changes or {})}
        values = {p: v for p, v in values.items() if p is not without}
        for parameter, value in values.items():
            self.pump.say(Config, JOINT, parameter, 0, value, 0)
        return values

    def commit(self, words: str, values: dict[Parameter, float], wrong: int = 0) -> None:
        """COMMIT of these values."""
        digest = configuration_hash(values) ^ wrong
        self.say(words, P.COMMIT, 0.0, len(values), digest)


def answers() -> str:
    """A dialogue with one joint, from power-up: what is sent, and its CONFIG_ACK."""
    d = Dialogue()
    d.say("KP 69.5", P.KP, 69.5)
    d.say("parameter 200", 200, 1.0)
    d.say("PERIOD 0", P.PERIOD, 0.0)
    d.say("PERIOD -1", P.PERIOD, -1.0)
    d.say("ARM_ID 999", P.ARM_ID, 999.0)
    d.say("ARM_ID 260.5", P.ARM_ID, 260.5)
    d.say("COUNTS_PER_UNIT 0", P.COUNTS_PER_UNIT, 0.0)
    d.note("PERIOD NaN", d.pump.give(_with_value(d.pump, bytes.fromhex("0000C07F"))))
    d.commit("COMMIT of KP and ARM_ID alone, right hash and total", {P.KP: 69.5, P.ARM_ID: 999.0})
    values = d.whole()
    d.commit("all parameters; COMMIT with another hash", values, wrong=1)
    d.commit("COMMIT with the right one", values)
    d.commit("the same COMMIT again", values)
    d.say("KP 69.5: the set is void", P.KP, 69.5)
    values = d.whole({P.SENSOR_SOURCE: 5.0})
    d.commit("all, SENSOR_SOURCE 5; COMMIT", values)
    values = d.whole({P.KINEMATICS: 2.0})
    d.commit("all, KINEMATICS 2; COMMIT", values)
    values = d.whole({P.DH_ALPHA_2: 1.0})
    d.commit("all, DH_ALPHA_2 1; COMMIT", values)
    values = d.whole({P.POSITION_MIN: 1.0, P.POSITION_MAX: 0.5})
    d.commit("all, POSITION_MIN 1, POSITION_MAX 0.5; COMMIT", values)
    values = d.whole({P.OVERSPEED_LIMIT: 3.1})
    d.commit("all, OVERSPEED_LIMIT 3.1, SPEED_LIMIT 2; COMMIT", values)
    values = d.whole(without=P.RATE_ERROR_LIMIT)
    d.commit("all but RATE_ERROR_LIMIT; COMMIT", values)
    d.commit("all; COMMIT", d.whole())
    d.pump.home()
    d.say("in READY: KP 69.5", P.KP, 69.5)
    return table(("sent", "answer", "its hash", "hash in HEARTBEAT after it"), d.rows)


def _with_value(pump: Pump, value: bytes) -> Frame:
    """CONFIG PERIOD with four bytes of a value that a sender of ours refuses to send."""
    from e2e.p05 import e2e_p05_protect  # noqa: PLC0415 (forges a frame)

    codec = pump.wire.codec(Config, JOINT)
    data = bytearray(codec.length)
    data[2], data[3] = 7, P.PERIOD
    data[5:9] = value
    assert codec.data_id is not None
    e2e_p05_protect(data, codec.data_id)
    return Frame(codec.id, bytes(data))
