"""The checks: one literal table."""

from collections.abc import Callable
from enum import Enum
from typing import Final, NamedTuple

from rfms_can.conform.checks import (
    angles,
    clock,
    configuring,
    cycles,
    duplicates,
    exact,
    homing,
    ladder,
    memory,
    poses,
    presence,
    refusals,
    runaway,
    safety,
    search,
    steps,
    tracing,
    transitions,
)
from rfms_can.conform.tester import Tester


class Kind(Enum):
    """What a check needs of the node and of what it drives."""

    BUS = "bus"
    """A bus; nothing moves."""
    SENSOR = "sensor"
    """A build that takes MEASURE and REFERENCE from the bus: its DAC follows the tester."""
    AXIS = "axis"
    """An axis that is free to move."""


class Check(NamedTuple):
    """One check.

    Attributes:
        id: number of the question, with a letter where it has several checks.
        title: what is done.
        want: what is required.
        kind: what it needs.
        run: asks the node; raises ``CheckFailed``. None where it is pending.
        required: whether the node must pass; else it is recommended.
        pending: why it is listed but not run.
    """

    id: str
    title: str
    want: str
    kind: Kind
    run: Callable[[Tester], None] | None
    required: bool = True
    pending: str = ""


B, S, A = Kind
LATER: Final = "waits for the faults of a later version: no node is asked for it yet"

CHECKS: Final[tuple[Check, ...]] = (
    Check(
        "1",
        "power on",
        "one HEARTBEAT, counter 0, PREOP, no configuration, right DBC hash; quiet",
        B,
        presence.power_on,
    ),
    Check(
        "1b",
        "a node that was never RESET: cycles without a configuration, HOME, START; ESTOP",
        "quiet; homed and enabled, no fault; DAC 0 tagged 0",
        S,
        memory.first_life,
    ),
    Check(
        "2",
        "NMT ANNOUNCE to all, and to the node",
        "HEARTBEAT, its counter one on",
        B,
        presence.announce,
    ),
    Check("3", "NMT to each other node", "quiet", B, presence.announce_others),
    Check(
        "4",
        "counters that go on, repeat, go back, leap, on CONFIG",
        "the rule of wire.md to the digit; each refusal counts one",
        B,
        presence.counter_rule,
    ),
    Check("4b", "the same on NMT", "no exception to the rule", B, presence.counter_rule_of_nmt),
    Check(
        "4c",
        "HEARTBEAT of the master with the same and with another boot id",
        "the next frame of each of its messages is taken whatever its counter; of no other",
        B,
        memory.master_that_restarts,
    ),
    Check(
        "5",
        "each bit of each frame that it hears flipped",
        "quiet, discarded + 1",
        B,
        refusals.one_bit,
    ),
    Check("6", "a CRC of another data ID", "quiet, discarded + 1", B, refusals.another_data_id),
    Check(
        "7",
        "longer, shorter and classic frames; a receiver need not look at BRS",
        "quiet, discarded + 1",
        B,
        refusals.wrong_length,
    ),
    Check(
        "8",
        "each field out of its range by the least it can be, NaN, infinity, no name",
        "quiet, discarded + 1; taken at the ends of the range",
        B,
        refusals.wrong_values,
    ),
    Check(
        "9",
        "frames that are for others, right and wrong ones",
        "quiet, discarded unchanged",
        B,
        refusals.for_others,
    ),
    Check("10", "the same SYNC twice", "one answer, discarded + 1", B, refusals.twice),
    Check(
        "11",
        "HOME without a configuration; START, STOP, QUICKSTOP in PREOP",
        "quiet, state and counters unchanged",
        B,
        refusals.not_yet,
    ),
    Check(
        "12",
        "each parameter, COMMIT; sets of both arms",
        "TAKEN bit for bit, the set's hash",
        B,
        configuring.each_parameter,
    ),
    Check(
        "12b",
        "each parameter at the ends of its range, and one float32 beyond",
        "TAKEN; REFUSED_VALUE, and not kept",
        B,
        configuring.ranges,
    ),
    Check(
        "13", "parameters without a name", "UNKNOWN, not part of the set", B, configuring.unknown
    ),
    Check(
        "14",
        "COMMIT with another hash or number, or with a parameter missing",
        "WRONG_HASH and the hash of what came; hash 0",
        B,
        configuring.wrong_commit,
    ),
    Check(
        "15",
        "parameters in reversed order; another CLOCK and BARRIER",
        "TAKEN, the same hash",
        B,
        configuring.in_any_order,
    ),
    Check(
        "16",
        "a parameter after COMMIT",
        "hash 0 in the next HEARTBEAT, an empty set begun",
        B,
        configuring.after_commit,
    ),
    Check(
        "17",
        "RESET with a set in force, and with an open one",
        "kept; cleared",
        B,
        configuring.reset_and_configuration,
    ),
    Check(
        "18",
        "CONFIG in HOMING, READY, OPERATIONAL, QUICKSTOP, FAULT",
        "REFUSED_STATE, nothing changed",
        S,
        configuring.refused_by_state,
    ),
    Check(
        "19",
        "contradictions, geometries and sources that the node does not have",
        "REFUSED_VALUE, UNSUPPORTED; hash 0",
        B,
        configuring.impossible,
    ),
    Check(
        "20",
        "HOME; SYNC HOMING, MEASURE, REFERENCE, in order and out of it",
        "HEARTBEAT HOMING with the first SYNC; one DAC a cycle tagged k; no ERROR",
        S,
        homing.frames_of_homing,
    ),
    Check(
        "21",
        "index and coarse position anywhere, the latter off by 0.24 intervals",
        "READY, the zero right to the count",
        S,
        homing.zero,
    ),
    Check(
        "22",
        "coarse position off by 0.3 intervals",
        "HOMING_FAILED, one DAC 0, FAULT, silence",
        S,
        homing.ambiguous,
    ),
    Check(
        "22b",
        "encoder and coarse position that move apart by 0.24 and 0.26 intervals",
        "goes on; HOMING_FAILED, torque off",
        S,
        homing.disagreeing,
    ),
    Check(
        "22c",
        "no index, a joint that stands at its torque limit; pauses, HOME again",
        "HOMING_FAILED after HOMING_TIME and STUCK_TIME, to the cycle; goes on",
        S,
        search.limits,
    ),
    Check(
        "22d",
        "coarse positions below, at and above the middle of several ranges",
        "searches upwards below it, else downwards; at FRICTION_SPEED it rests",
        S,
        search.direction,
    ),
    Check(
        "22e",
        "a quarter of an index interval to the bit, and a count more",
        "taken; HOMING_FAILED",
        S,
        search.to_the_bit,
    ),
    Check(
        "23",
        "frozen, reversed, running-off encoder or reversed motor while homing",
        "HOMING_FAILED or RUNAWAY within a bound, torque off",
        A,
        None,
        pending=LATER,
    ),
    Check("24", "STOP, QUICKSTOP, RESET in HOMING; HOME again", "PREOP; homes", S, homing.given_up),
    Check(
        "25",
        "READY with every state in SYNC; HOME again",
        "DAC that holds with SYNC HOMING, else quiet",
        S,
        homing.held,
    ),
    Check(
        "26",
        "START with another hash, with its own, with none; START again",
        "ignored; OPERATIONAL, counters from 0; ignored",
        S,
        cycles.start,
    ),
    Check(
        "26b",
        "START within a cycle, after the others' errors",
        "they count for nothing",
        S,
        cycles.start_within_a_cycle,
    ),
    Check(
        "27",
        "SYNC 0 with the set-point where it stands",
        "error 0, rate = -velocity, acceleration 0, tag 0",
        S,
        cycles.first_cycle,
    ),
    Check(
        "28",
        "MEASURE, SETPOINT and five errors in every order",
        "own ERROR with the later of the first two; DAC with the sixth error; each once",
        S,
        cycles.order,
    ),
    Check(
        "29",
        "errors, rates, rows, gravity given, each term alone and all at once",
        "DAC within 1 code of the law",
        S,
        tracing.traces_of("laws"),
    ),
    Check(
        "29b",
        "ROWS of sets that SYNC names, and of others",
        "they act from the SYNC that names them",
        S,
        cycles.rows_in_force,
    ),
    Check(
        "29c",
        "torques between codes and beyond; limits, dead bands to the bit; parameters that are 0",
        "the nearest code; the law",
        S,
        tracing.traces_of("edges"),
    ),
    Check(
        "30",
        "golden trace: every state of a set-point, both modes, both blends",
        "commanded within 1e-6 rad, rate 1e-3, acceleration 0.1",
        S,
        tracing.traces_of("setpoints"),
    ),
    Check(
        "30b",
        "every state of a set-point after every other",
        "taken as the table of states says, else as one that is lost",
        S,
        transitions.succession,
    ),
    Check(
        "30c",
        "one and two set-points lost right before START, r going on evenly",
        "the transition of set-points that all came, within 1e-6 rad",
        S,
        transitions.lost_before_start,
    ),
    Check(
        "31",
        "random poses of each arm in all configurations, unreachable ones",
        "angle to 1e-6 rad; quiet",
        S,
        angles.solved,
    ),
    Check(
        "31b",
        "JOINT_SETPOINT with and without the joint's bit, at the ends of its range",
        "its angle; else that of the pose",
        S,
        angles.by_whom,
    ),
    Check(
        "31c",
        "a straight wrist, joint 4 told and not told",
        "joint 4 there or as it was; 1e-6 rad",
        S,
        angles.straight_wrist,
    ),
    Check(
        "31d",
        "poses through more than a turn: at rest, to a far goal, along a path",
        "the turn goes on from the pose solved last; 1e-6 rad",
        S,
        angles.turns,
    ),
    Check(
        "31e",
        "arms of other shapes, half a micrometre on either side of the ends of their reach",
        "angle to 1e-6 rad; quiet",
        S,
        poses.shapes,
    ),
    Check(
        "31f",
        "wrists almost straight, after poses taken, refused, second, out of reach; a start between",
        "joint 4 held below |S5| 1e-5 as the last pose above left it; 1e-6 rad",
        S,
        poses.wrists,
    ),
    Check(
        "31g",
        "poses at the ends of the joint's range",
        "angle to 1e-6 rad half of the margin beyond; quiet",
        S,
        poses.ends,
    ),
    Check(
        "31h",
        "a history that lost set-points carry on beyond the range by turns",
        "the nearest turn inside the range; 1e-6 rad",
        S,
        poses.far_turns,
    ),
    Check(
        "31i",
        "a second pose that comes on the way to a goal more than half a turn away",
        "on the turn of the goal; 1e-6 rad",
        S,
        poses.second_turns,
    ),
    Check(
        "32",
        "frames of a set-point in many orders; each late, lost, old",
        "waits for all of them, and for no others",
        S,
        cycles.whole_setpoint,
    ),
    Check(
        "32b", "a pose that is not announced; an unknown bit of extras", "quiet", S, cycles.surplus
    ),
    Check(
        "33", "COMPLY 1e-4", "error + 1e-4, its rate while the rows are rigid", S, cycles.compliant
    ),
    Check(
        "34",
        "BIAS of either sign, and none",
        "force DAC in that cycle, 0 in the next without",
        S,
        cycles.biased,
    ),
    Check(
        "35",
        "SETPOINT lost: two cycles, one good, then for ever",
        "held; EMCY at 3, 5 and 25 cycles: stop, damping, torque off",
        S,
        ladder.setpoint_lost,
    ),
    Check(
        "35b",
        "SETPOINT old, ahead, no rotation, unreachable, not complete, out of sequence",
        "as one that is lost",
        S,
        ladder.held_rung,
    ),
    Check(
        "35c",
        "SETPOINT in a stop, SYNC OPERATIONAL and QUICKSTOP",
        "missed in the first only; MEASURE of any cycle is answered",
        S,
        ladder.stop_is_not_disturbed,
    ),
    Check(
        "35d",
        "a joint that is damped leaves its range, to the bit, and farther than EMCY can say",
        "torque off; value cut to 1e9",
        S,
        ladder.damping_leaves_the_range,
    ),
    Check(
        "36",
        "MEASURE lost or old: two cycles, one good, two, one good, three",
        "held; EMCY, one DAC 0, FAULT, silence",
        S,
        ladder.measure_lost,
    ),
    Check(
        "36b",
        "MEASURE lost in a stop; of another cycle",
        "torque off after 3; taken",
        S,
        ladder.measure_lost_in_a_stop,
    ),
    Check(
        "37",
        "ERROR of each other joint lost",
        "held; a stop after 3, the joint named",
        S,
        ladder.error_lost,
    ),
    Check(
        "38",
        "a set of rows that does not come",
        "the old one acts; a stop after 3",
        S,
        ladder.rows_lost,
    ),
    Check(
        "38b",
        "HOMING while SYNC says OPERATIONAL, no SETPOINT",
        "PREOP after 3; HOME only after RESET",
        S,
        ladder.while_homing,
    ),
    Check(
        "39",
        "set-point steps inside and beyond the bound, after 0 to 2 held cycles",
        "taken; EMCY at once, none of the step acts, QUICKSTOP",
        S,
        steps.setpoint_step,
    ),
    Check(
        "39d",
        "a step beyond the bound one good cycle after two that were held",
        "EMCY, QUICKSTOP: holding does not widen it for ever",
        S,
        steps.step_after_holding,
    ),
    Check("39b", "an error beyond 2 rad", "as a step", S, steps.too_far),
    Check(
        "39c", "the stop after a step", "never faster than the joint was", S, None, pending=LATER
    ),
    Check(
        "40",
        "encoder jumps inside and beyond the bound",
        "taken; two cycles predicted, then EMCY, QUICKSTOP",
        S,
        steps.encoder_jump,
    ),
    Check(
        "40b", "two jumps, one good sample, three times over", "goes on", S, steps.encoder_returns
    ),
    Check(
        "40c",
        "encoder steps and jumps after a cycle without MEASURE",
        "twice as far is taken; EMCY with twice the bound",
        S,
        steps.encoder_unseen,
    ),
    Check(
        "40d",
        "the end of the range, passed and rushed at",
        "torque off 0.05 rad beyond; a stop in time",
        S,
        steps.end_of_range,
    ),
    Check(
        "40e",
        "an encoder that goes away from the set-point, slowly, fast, braked, with halts",
        "EMCY and torque off in the cycle that is one too many; goes on",
        S,
        runaway.runaway,
    ),
    Check(
        "40f",
        "the same in a stop, and while homing",
        "EMCY and torque off",
        S,
        runaway.runaway_of_a_stop,
    ),
    Check(
        "40g",
        "QUICKSTOP, an index and a pause while the encoder goes away",
        "counted from there",
        S,
        runaway.begins_again,
    ),
    Check(
        "40h",
        "encoder and set-point steps of the bound to the bit, and the next number",
        "taken; a jump; a step",
        S,
        exact.steps,
    ),
    Check(
        "40i",
        "COMPLY that stays while the set-point steps",
        "its own steps alone count",
        S,
        exact.displaced_steps,
    ),
    Check(
        "40j",
        "motions away that meet a bound of RUNAWAY to the bit",
        "torque off; goes on",
        S,
        exact.runaways,
    ),
    Check(
        "41",
        "no SYNC, by the clock that CONFIG tells, BARRIER in lockstep",
        "EMCY at 3, 5, 25 periods, each after half of one more",
        S,
        clock.no_sync,
    ),
    Check(
        "41b",
        "two SYNCs lost, again and again; none in READY, PREOP, HOMING",
        "goes on; nothing; PREOP",
        S,
        clock.sync_returns,
    ),
    Check(
        "41c",
        "no SYNC in lockstep, where BARRIER is long",
        "EMCY within a bound in time",
        S,
        None,
        pending=LATER,
    ),
    Check(
        "41d",
        "no SYNC after a cycle that lacked MEASURE, SETPOINT or ERROR",
        "counted when SYNC is overdue, and once",
        S,
        clock.cycle_cut_short,
    ),
    Check(
        "41e",
        "encoder steps after SYNCs that were lost or left out",
        "as far as the cycles since the last sample allow, each once",
        S,
        clock.encoder_meanwhile,
    ),
    Check(
        "42",
        "SYNC skips 1, 2, 4 and 9 numbers",
        "goes on; steps may be larger, up to 4 cycles'",
        S,
        clock.numbers_skipped,
    ),
    Check(
        "42b",
        "SYNC 0, 1 and 2 first after START",
        "those that are skipped are held",
        S,
        clock.after_start,
    ),
    Check(
        "43",
        "QUICKSTOP; START, STOP, HOME; RESET, HOME, START",
        "a stop; ignored; comes up again, homed at once",
        S,
        safety.quickstop,
    ),
    Check(
        "43b",
        "homing, stops and missing frames by golden traces",
        "DAC within 1 code, EMCY in its cycle",
        S,
        tracing.traces_of("stops"),
    ),
    Check(
        "43c",
        "QUICKSTOP and a step before and after MEASURE of a cycle",
        "owes no DAC once the sample is taken; else MEASURE",
        S,
        memory.stop_within_a_cycle,
    ),
    Check(
        "43d",
        "ROWS, then STOP and RESET in PREOP, RESET, another configuration",
        "kept; forgotten",
        S,
        memory.rows_forgotten,
    ),
    Check(
        "43e",
        "START after STOP, stops commanded twice, lives at random, by golden traces",
        "nothing is left of before",
        S,
        tracing.traces_of("lives"),
    ),
    Check(
        "44",
        "RESET, HOME, START in OPERATIONAL",
        "ignored, counters go on",
        S,
        safety.commands_in_operational,
    ),
    Check(
        "45",
        "ESTOP in each state; again",
        "FAULT, EMCY, one DAC 0 where DACs went out, silence; nothing",
        S,
        safety.estop,
    ),
    Check(
        "45b",
        "ESTOP before MEASURE, in OPERATIONAL, QUICKSTOP, HOMING",
        "DAC 0 with the cycle of the last sample",
        S,
        memory.cycle_of_dac_0,
    ),
    Check(
        "46",
        "ESTOP with each bit wrong; as a classic frame",
        "quiet, discarded + 1; taken",
        B,
        safety.estop_frames,
    ),
    Check(
        "47",
        "whole cycles in FAULT; RESET, HOME, START",
        "never enabled by itself; comes up again",
        S,
        safety.out_of_fault,
    ),
    Check(
        "47b", "faults before START", "forgotten, the ladder begins again", S, safety.clean_record
    ),
    Check(
        "48",
        "SYNC of another DBC",
        "FAULT, EMCY, one DAC 0 where DACs went out, once",
        S,
        safety.another_dbc,
    ),
    Check(
        "49",
        "faults that are held, then ESTOP",
        "a bit for each, and bit 0",
        S,
        safety.register_bits,
    ),
    Check(
        "50",
        "SYNC of many numbers in PREOP",
        "HEARTBEAT with each multiple of 12, no other",
        B,
        presence.heartbeat_phase,
    ),
    Check(
        "51",
        "real time, 10,000 cycles",
        "ERROR and DAC within RfmsResponseTime",
        S,
        None,
        pending=LATER,
    ),
    Check(
        "52",
        "encoder runs off, sticks, reverses; tachometer against encoder; torque without motion",
        "each found within its bound",
        A,
        None,
        pending=LATER,
    ),
    Check(
        "53",
        "a HEARTBEAT of a second master while the first drives",
        "does not take over",
        S,
        safety.second_master,
    ),
    Check(
        "53b",
        "each of its own identifiers from elsewhere, in each state",
        "DUPLICATE_NODE: a stop, told once, until RESET",
        S,
        duplicates.duplicate,
    ),
    Check(
        "53c",
        "a second master",
        "FOREIGN_MASTER",
        B,
        None,
        pending=LATER,
    ),
)
