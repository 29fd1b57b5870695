"""The third node computes every vector that the handbook prints."""

import math
import re
from typing import Any

import pytest
from generated import DOCS
from third_node import codec, kinematics, law, protection, setpoint
from third_node.configuration import NUMBER, TABLE, Geometry, Parameters, hash_of, value_is_good
from third_node.detectors import Amplifier, Motor, Tachometer, stop_begin
from third_node.fit import weights
from third_node.homing import Homing
from third_node.node import Node
from third_node.stop import Stop

PAGES = ("node.md", "node-kinematics.md", "node-setpoint.md", "node-law.md", "node-detectors.md")
BLOCK = re.compile(r"<!-- begin draw_node.py: ([\w-]+) -->(.*?)<!-- end", re.DOTALL)
BLOCKS = {
    name: body
    for page in PAGES
    for name, body in BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))
}
NAMES = {message.name: can_id for can_id, message in codec.MESSAGES.items()}
STATES = ("IDLE", "LINEAR", "PRE", "START", "BLEND")
TAU = codec.float32(0.004)
approx = pytest.approx


def table(name: str) -> list[list[str]]:
    """Rows of the last table of a block."""
    lines = [line for line in BLOCKS[name].splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines]
    return rows[2:]


def octets(text: str) -> bytes:
    """Bytes in hexadecimal."""
    return bytes.fromhex(text.replace("`", ""))


def numbers(text: str) -> list[float]:
    """Numbers between commas."""
    return [float(x) for x in text.replace("`", "").split(",")]


def rounded(values: list[float]) -> list[float]:
    """As they travel."""
    return [codec.float32(x) for x in values]


def number(text: str) -> float:
    """A number of a table, NaN included."""
    return float(text)


def parameters() -> dict[int, float]:
    """The configuration of the pages."""
    return {
        int(row[0]): codec.unpack(NAMES["CONFIG_3"], bytes(5) + octets(row[5]) + bytes(3))["value"]
        for row in table("parameters")
    }


VALUES = parameters()
P = Parameters(VALUES)


# --- node.md --------------------------------------------------------------------------------------


def test_frames_and_parameters_are_those_of_the_pages() -> None:
    node = Node(3)
    heard = {int(can_id, 16): (name, int(length)) for can_id, name, length, _ in table("frames")}
    assert set(heard) == {0, *node.receivers}
    for can_id, told in heard.items():
        assert told == (codec.MESSAGES[can_id].name, codec.MESSAGES[can_id].length)
    assert set(VALUES) == set(TABLE)
    for row in table("parameters"):
        known, name, span = int(row[0]), row[1], row[3]
        low, high = re.findall(r"-?[\d.][\d.e+-]*", span)[:2]
        kind = "whole" if "whole" in span else "magnitude" if "magnitude" in span else ""
        assert TABLE[known] == (name, float(low), float(high), kind)
        assert value_is_good(known, VALUES[known])


def test_protected_frames() -> None:
    assert protection.crc16(b"123456789") == 0x29B1
    for name, identity, counter, told, data in table("crc"):
        if name == "ESTOP":
            continue
        fields: dict[str, Any] = {}
        for item in told.split(", "):
            key, value = item.split(" ")
            whole = re.fullmatch(r"-?(0x)?[0-9A-Fa-f]+", value)
            fields[key] = int(value, 0) if whole else float(value)
        can_id = NAMES[name]
        packed = protection.protect(can_id, codec.pack(can_id, fields), int(counter))
        assert packed == octets(data)
        assert protection.data_id(can_id) == int(identity, 16)


def test_counters() -> None:
    receiver = protection.Receiver()
    refused = 0
    for counter, says, discarded in table("counters"):
        taken = receiver.check(int(counter))
        refused += not taken
        assert (taken, refused) == (says == "taken", int(discarded)), counter


def test_hashes() -> None:
    two = {0: 260.0, 1: TAU}
    wanted = [int(row[2], 16) for row in table("hashes")]
    assert [hash_of(two), hash_of({**two, 28: 2.0, 29: 2.0}), hash_of(VALUES)] == wanted


class Bench:
    """Speaks to joint 3, brought to OPERATIONAL where the pages have it: at 21343 counts."""

    def __init__(self) -> None:
        self.node = Node(3, 0x5EED0003)
        self.node.start()
        self._counters: dict[int, int] = {}
        for known, value in VALUES.items():
            self.say("CONFIG_3", parameter=known, value=value)
        self.say("CONFIG_3", parameter=255, total=len(VALUES), hash=hash_of(VALUES))
        self.say("NMT", command=1)
        interval = int(P.INDEX_INTERVAL_COUNTS)
        coarse = ((21343 + 1234) / P.COUNTS_PER_UNIT - P.COARSE_ZERO) / P.COARSE_PER_CODE
        pulse = (21343 + 1234) // interval * interval - 1234
        self.say("SYNC", state=2, dbc_hash=codec.DBC_HASH)
        self.say("MEASURE_3", counts=21343)
        self.say("REFERENCE_3", coarse_adc=round(coarse), index_counts=pulse, index_valid=1)
        assert self.node.homing.zero == -1234
        self.say("NMT", command=2)
        self._counters.clear()

    def say(self, name: str, **fields: Any) -> None:
        """A frame for it."""
        can_id = NAMES[name]
        counter = self._counters[can_id] = self._counters.get(can_id, -1) + 1
        self.node.receive(
            can_id, protection.protect(can_id, codec.pack(can_id, fields), counter), 0
        )


def whole_frames() -> list[tuple[bool, int, bytes]]:
    """Frames of the two cycles, in order, and whether they are the node's."""
    frames: list[tuple[bool, int, bytes]] = []
    for line in BLOCKS["cycle"].splitlines():
        if found := re.match(r"(-> node|node ->)  ([0-9A-F]{3})  \[\d+\]  (.*)", line):
            frames.append((found[1] == "node ->", int(found[2], 16), octets(found[3])))
        elif re.fullmatch(r" +[0-9A-F ]+", line):
            its, can_id, begun = frames.pop()
            frames.append((its, can_id, begun + octets(line)))
    return frames


def test_two_whole_cycles_from_pose_to_dac() -> None:
    node = Bench().node
    made: list[tuple[int, bytes]] = []
    for its, can_id, data in whole_frames():
        if not its:
            made += node.receive(can_id, data, 0)
    wanted = [(can_id, data) for its, can_id, data in whole_frames() if its]
    assert [can_id for can_id, _ in made] == [can_id for can_id, _ in wanted]
    tolerances = {"error": 1e-6, "error_rate": 1e-3, "acceleration": 0.1, "current_dac": 1}
    for (can_id, data), (_, same) in zip(made, wanted, strict=True):
        fields = codec.unpack(can_id, data)
        fields.pop("e2e_crc")
        for name, value in fields.items():
            told = codec.unpack(can_id, same)[name]
            assert value == approx(told, abs=tolerances.get(name, 0.0)), (can_id, name)
    assert node.rows.gravity == codec.float32(0.83)


def test_glitches() -> None:
    bench = Bench()
    node = bench.node
    bench.say("SYNC", cycle=0, state=4, dbc_hash=codec.DBC_HASH)
    bench.say("MEASURE_3", cycle=0, counts=21343)
    for cycle, counts, speed, theta, count, state in table("glitches"):
        k = int(cycle)
        bench.say("SYNC", cycle=k, state=4, dbc_hash=codec.DBC_HASH)
        bench.say("MEASURE_3", cycle=k, counts=int(counts), velocity_adc=int(speed))
        node.ladder[2] = 0  # no SETPOINT here
        assert node.theta == approx(float(theta), abs=1e-8)
        assert node.ladder[7] == int(count)
        assert node.state == {"OPERATIONAL": 4, "QUICKSTOP": 5}[state]


# --- node-kinematics.md ---------------------------------------------------------------------------


def geometry_of(arm: str) -> Geometry:
    lengths = {row[0]: [float(x) for x in row[1:]] for row in table("geometry")}[arm]
    a2, a3, d4, d = (float(round(x * 1e6)) for x in lengths)
    return Geometry({**VALUES, 65: a2, 66: a3, 71: d, 72: 0.0, 73: d4})


def poses_in(name: str) -> list[list[list[float]]]:
    found = [re.findall(rf"^{v} = (.*)$", BLOCKS[name], re.MULTILINE) for v in "oap"]
    return [[rounded(numbers(x)) for x in pose] for pose in zip(*found, strict=True)]


def angles(
    arm: str, pose: list[list[float]], code: int, held: float = 0.0, joints: range = range(1, 7)
) -> list[float]:
    made = []
    for joint in joints:
        memory = kinematics.Held()
        memory.set_angle(held)
        o, a, p = pose
        angle = kinematics.solve(joint, geometry_of(arm), o, a, p, code, memory)
        if angle is not None:
            angle = kinematics.nearest_turn(angle, 0.0, -10.0, 10.0)
        made.append(math.nan if angle is None else angle)
    return made


def test_poses() -> None:
    (pose,) = poses_in("branches")
    for code, *wanted in table("branches"):
        assert angles("puma260", pose, int(code)) == approx(list(map(float, wanted)), abs=2e-9)
    for arm, o, a, p, code, *wanted in table("poses"):
        pose = [rounded(numbers(x)) for x in (o, a, p)]
        made = angles(arm, pose, int(code))
        assert made == approx(list(map(float, wanted)), abs=2e-9, nan_ok=True)


def test_straight_wrists_and_turns() -> None:
    (pose,) = poses_in("straight")
    for held, *wanted in table("straight"):
        made = angles("puma260", pose, 2, float(held), range(4, 7))
        assert made == approx(list(map(float, wanted)), abs=2e-8)
    for angle, previous, lower, upper, taken in table("turns"):
        found = kinematics.nearest_turn(*map(float, (angle, previous, lower, upper)))
        assert (math.nan if found is None else found) == approx(float(taken), abs=1e-9, nan_ok=True)


def test_told_theta4() -> None:
    straight, bent = poses_in("told")
    memory = {joint: kinematics.Held() for joint in (4, 5, 6)}
    for word, theta4, *wanted in table("told"):
        o, a, p = straight if word == "straight" else bent
        for joint, angle in zip((4, 5, 6), wanted, strict=True):
            if theta4:
                memory[joint].set_angle(codec.float32(float(theta4)))
            made: float | None = codec.float32(float(theta4 or 0.0))
            if not (theta4 and joint == 4):  # bit 3 tells joint 4 its angle
                geometry = geometry_of("puma260")
                made = kinematics.solve(joint, geometry, o, a, p, 2, memory[joint])
            assert made == approx(float(angle), abs=2e-8)


# --- node-setpoint.md -----------------------------------------------------------------------------


def test_weights() -> None:
    kinds = ("value", "rate", "acceleration", "jerk")
    for at, samples, of, wanted in table("weights"):
        made = weights(int(samples), at == "one ahead")[kinds.index(of)]
        assert made == approx(numbers(wanted), rel=1e-5, abs=1e-9)


def told(state: str, mode: str, blend: int, r: float, p: float, t_acc: float) -> dict[str, Any]:
    """SETPOINT_1."""
    return {
        "state": STATES.index(state),
        "mode": ("JOINT", "CARTESIAN").index(mode),
        "blend": blend,
        "r": codec.float32(r),
        "blend_p": codec.float32(p),
        "acceleration_time": codec.float32(t_acc),
    }


@pytest.mark.parametrize(("block", "begin"), [("joint", 0.3), ("line", 0.8), ("stopped", 0.3)])
@pytest.mark.parametrize("blend", [0, 1])
def test_motions(block: str, begin: float, blend: int) -> None:
    sp = setpoint.SetPoint(TAU, begin)
    for row in table(block):
        _, state, mode, r, p, q1, q2, theta, rate, acceleration, thesis = row
        if state == "missed":
            sp.hold()
        else:
            first = told(state, mode, blend, float(r), float(p), 0.02)
            may = sp.may_follow(first["state"], first["mode"], first["blend_p"], bool(q2))
            assert may, row
            sp.step(first, float(q1), float(q2) if q2 else None)
        assert sp.theta == approx(float(theta if blend else thesis), abs=2e-9), row
        if blend:
            assert sp.rate == approx(float(rate), abs=1e-5), row
            assert sp.acceleration == approx(float(acceleration), abs=2e-3), row


@pytest.mark.parametrize("start", [40, 101, 181])
def test_slow_departures(start: int) -> None:
    def q1(k: int) -> float:
        return 0.8 + 0.1 * (1.0 - math.cos(0.02 * k))

    sp = setpoint.SetPoint(TAU, 0.8)
    sp.step(told("IDLE", "CARTESIAN", 1, 0.0, 0.0, 0.02), q1(0), q1(0))
    sp.step(told("START", "CARTESIAN", 1, 1.0, 0.0, 0.02), q1(1), None)
    for k in range(2, start):
        state = "BLEND" if k < 12 else "LINEAR" if k < start - 2 else "PRE"
        p = (k - 1) / 10 if k < 12 else 0.0
        sp.step(told(state, "CARTESIAN", 1, 1.0, p, 0.02), q1(k), 1.1 if state == "PRE" else None)
    rows = [row for row in table("departing") if int(row[0]) == start]
    for n, (_, _, theta, rate, acceleration) in enumerate(rows):
        first = told("BLEND" if n else "START", "JOINT", 1, 1.0, n / 600, 1.2)
        sp.step(first, 1.1 if n else q1(start), None if n else 1.1)
        assert sp.theta == approx(float(theta), abs=2e-9)
        assert sp.rate == approx(float(rate), abs=1e-5)
        assert sp.acceleration == approx(float(acceleration), abs=2e-3)


def test_succession() -> None:
    for state, after in table("succession"):
        plain = re.sub(r"\(.*?\)", "", after).replace(" ", "").split(",")
        for last in STATES:
            sp = setpoint.SetPoint(TAU, 0.0)
            sp.state = STATES.index(last)
            assert sp.may_follow(STATES.index(state), 1, 0.5, True) == (last in plain)


# --- node-law.md ----------------------------------------------------------------------------------

SIXES = {
    name: rounded(
        numbers(re.findall(rf"^{name}\s+([-0-9., ]+)$", BLOCKS["given"], re.MULTILINE)[0])
    )
    for name in ("C", "M", "own", "errors", "rates", "accelerations")
}
NONE = [0.0] * 6


def law_cycle(own: law.Law, k: int, given: dict[str, Any]) -> tuple[float, tuple[int, int]]:
    """Torque and codes of a cycle, given the words of the page."""
    rows = law.Rows(3)
    rows.law_row = SIXES[given.get("law_row", "own")]
    rows.inertia = SIXES["M"] if "inertia_row" in given else NONE
    rows.gravity = codec.float32(given.get("gravity", 0.0))
    rows.damping = given.get("damping", 0.0)
    for name in ("law", "selection", "specification"):
        setattr(rows, name, int(given.get(name, 0)))
    six = [SIXES[name] if name in given else NONE for name in ("errors", "rates", "accelerations")]
    for place, name in enumerate(("error 3", "rate 3")):
        if name in given:
            six[place] = [0.0, 0.0, codec.float32(given[name]), 0.0, 0.0, 0.0]
    bias = own.cut_bias(codec.float32(given.get("bias", 0.0)))
    desired, speed = (codec.float32(given.get(name, 0.0)) for name in ("desired", "speed"))
    torque = own.servo(rows, six, desired, speed, k, bias)
    return torque, own.codes(torque, bias)


def words(text: str) -> dict[str, Any]:
    """Words and numbers between commas."""
    found: dict[str, Any] = {}
    for item in text.split(", "):
        key, value = item.rsplit(" ", 1)
        found[key] = float(value) if re.fullmatch(r"-?[0-9.]+", value) else value
    return found


def test_single_cycles() -> None:
    for case, given, terms, torque, current, force in table("single"):
        own = law.Law(3, P)
        made, codes = law_cycle(own, 0, words(given))
        assert made == approx(float(torque), abs=2e-6), case
        assert codes == (int(current), int(force)), case
        shown = words(terms)
        for name, value in own.terms.items():
            if name != "transfer":
                assert value == approx(shown.get(name, 0.0), abs=2e-6), (case, name)


def rest_given(k: int) -> dict[str, Any]:
    if k < 2:
        return {"error 3": 0.001, "desired": 0.1}
    return {"error 3": -0.001 if k < 68 else 0.0002}


def complying_given(k: int) -> dict[str, Any]:
    if k < 3:
        return {"error 3": 0.001, "desired": 0.1, "gravity": 0.83}
    if k >= 48:
        return {"error 3": 0.001, "specification": 2, "gravity": 0.83}
    rows = {"law_row": "C", "inertia_row": "M", "damping": 4.0, "selection": 4}
    moving = {"errors": "all", "rates": "all", "speed": 0.05 if k <= 9 else 0.0}
    return {**rows, **moving, "specification": 1, "gravity": 0.83}


@pytest.mark.parametrize("block", ["rest", "complying"])
def test_runs(block: str) -> None:
    dither = {NUMBER["DITHER_FRACTION"]: codec.float32(0.8)} if block == "complying" else {}
    given = complying_given if block == "complying" else rest_given
    own = law.Law(3, Parameters({**VALUES, **dither}))
    rows = {int(row[0]): row[1:] for row in table(block)}
    for k in range(max(rows) + 1):
        torque, codes = law_cycle(own, k, given(k))
        if k in rows:
            *wanted, current = rows[k]
            terms = own.terms
            made = [terms["integral"], terms["friction"], own.friction.dither, terms["transfer"]]
            assert [*made, torque] == approx(list(map(float, wanted)), abs=2e-6), k
            assert codes[0] == int(current), k


def test_codes_and_references() -> None:
    for torque, current, force in table("codes"):
        assert law.Law(3, P).codes(float(torque), float(torque)) == (int(current), int(force))
    for counts, coarse, valid, index, angle, residual, result, zero, theta in table("references"):
        homing = Homing(P, None)
        reference = {
            "coarse_adc": int(coarse),
            "index_valid": int(valid),
            "index_counts": int(index),
        }
        homing.step(int(counts), reference, False)
        word = "HOMING_FAILED" if homing.failure else "referenced" if homing.found else "searching"
        assert word == result
        assert homing.coarse == approx(float(angle), abs=1e-9)
        assert homing.residual == approx(float(residual), abs=1e-6)
        if zero:
            assert homing.zero == int(zero)
            assert homing.theta == approx(float(theta), abs=1e-9)


def test_stop_and_hold() -> None:
    (first, *rest) = table("stop")
    stop = Stop(P, float(first[1]), float(first[2]))
    for cycle, *wanted in rest:
        stop.ramp(-99.0 - int(cycle))
        made = [stop.position, stop.speed, stop.acceleration]
        assert made == approx(list(map(float, wanted)), abs=2e-6)
    stop = Stop(P, 0.5, 0.15)
    rows = {int(row[0]): row[1:] for row in table("hold")}
    for k in range(1, 22):
        stop.ramp(0.5 + 0.0001 * min(k, 6) + (0.0002 if k > 19 else 0.0))
        if k in rows:
            _, speed, position = map(float, rows[k])
            assert [stop.speed, stop.position] == approx([speed, position], abs=2e-6)


# --- detectors ------------------------------------------------------------------------------------


def test_tachometer() -> None:
    watch, before, counts_before = Tachometer(P), 0.0, 0
    for _, counts, code, off, up, down, says in table("tachometer"):
        v = int(code) * P.RATE_PER_CODE
        moved = (int(counts) - counts_before) / P.COUNTS_PER_UNIT
        assert moved / TAU - (v + before) / 2 == pytest.approx(float(off), abs=1e-6)
        assert watch.differs(moved, v, before) == (says == "trips")
        assert (watch.up, watch.down) == pytest.approx((float(up), float(down)), abs=1e-9)
        before, counts_before = v, int(counts)
    assert says == "trips"


def test_currents() -> None:
    watch = Amplifier(P)
    for current, force in ((-200, 0), (-210, 0), (-190, 40), (-205, 0), (-200, 0)):
        assert watch.border_passed(-2048) is None
        watch.drive(current, force)
    for code, says in table("currents"):
        border = watch.border_passed(int(code))
        assert (border is None) == (says == "")
        assert border is None or border == pytest.approx(float(says), abs=1e-3)


def test_heat() -> None:
    watch = Motor(P)
    for torque, heat in table("heat"):
        assert not watch.overheats(float(torque))
        assert watch.heat == pytest.approx(float(heat), abs=1e-9)


def test_begins() -> None:
    for row in table("begins"):
        p, w, theta, v, position, speed = map(float, row)
        made = stop_begin(P, (p, w), (theta, v))
        assert made == pytest.approx((position, speed), abs=1e-6)
