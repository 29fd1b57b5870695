"""The control cycle: when SYNC goes out, what goes with it, and when the cycle is over.

Cycle k: SYNC and SETPOINT go out; MEASURE comes, and the math processor's rows go out; ERROR and
DAC come; when all have answered the set-point of cycle k+1 is made (pipelined, Fig. 6.6) and the
cycle is closed.
"""

from collections.abc import Sequence
from typing import NamedTuple

from rfms_can.arm import Arm
from rfms_can.master.force.control import ForceControl, Settings
from rfms_can.master.listener import Listener
from rfms_can.master.motion import Motion
from rfms_can.master.phases import BUS_STATES, CYCLING, Phase
from rfms_can.master.settings import Clock, MasterSettings
from rfms_can.master.statistics import RunStatistics
from rfms_can.master.stillness import Stillness
from rfms_can.node.protocol import NOTHING
from rfms_can.setpoint.cartesian import CartesianSetpoint
from rfms_can.wire.contract import Wire
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import HEARTBEAT_EVERY


class Carried(NamedTuple):
    """A set-point that was sent.

    Attributes:
        tick: the generator's, one after that at which it was made.
        cycle: whose SETPOINT it is.
        sent_ns: when it was handed to the bus.
    """

    tick: int
    cycle: int
    sent_ns: int


class ControlCycle(Listener):
    """The master's half that knows time; what a phase does at the end of a cycle is not its own.

    Attributes:
        closed: control cycles closed since the first SYNC: programs wait by it.
        motion: programs' moves and the trajectory generator.
        force_control: compliance, bias force and guarded moves.
        statistics: numbers of the run.
        stillness: for how long arm and jaw have stood still.
        paced: lockstep cycles are no shorter than the period; for a bus that idles.
        carried: the set-point sent last.
        fault: why the run was halted, or None.
    """

    fault: str | None

    def __init__(self, arm: Arm, wire: Wire, boot_id: int, settings: MasterSettings) -> None:
        super().__init__(arm, wire, boot_id, settings)
        period_s = settings.period_ns * 1e-9
        self.closed = 0
        self.motion = Motion(arm, period_s, settings.blend)
        how = Settings(settings.law, settings.closed, settings.friction, self.gains)
        self.force_control = ForceControl(arm, self.broadcast.math, how, period_s)
        self.motion.vet = self.force_control.refusal
        self.statistics = RunStatistics(period_s)
        self.stillness = Stillness(arm)
        self.paced = settings.paced
        self.carried = Carried(0, -1, 0)
        self._lockstep = settings.clock is Clock.LOCKSTEP
        self._deadline_ns: int | None = 0
        self._setpoint: CartesianSetpoint | None = None
        self._displacement: tuple[float, ...] | None = None
        self._began_ns = 0

    def _at_close(self) -> None:
        """What the phase does when a cycle is closed."""
        raise NotImplementedError

    def _missed(self, lost: str | None) -> None:
        """A cycle is incomplete; ``lost`` says who has been silent for too long, if anybody."""
        raise NotImplementedError

    def next_deadline_ns(self) -> int | None:
        """Next SYNC, or in lockstep the barrier; before cycles run, the next call for nodes."""
        return 0 if self._urgent else self._deadline_ns

    def on_time(self, now_ns: int) -> Sequence[Frame]:
        """Begin the next cycle, closing an incomplete one; or call for nodes again."""
        deadline_ns = self._deadline_ns
        if self._urgent:
            self._urgent = False
            return self._flush()
        if deadline_ns is None or now_ns < deadline_ns:
            return NOTHING
        self._now_ns = now_ns
        if self.phase in CYCLING:
            complete = not self._answers.missing
            if not complete:
                self._close_incomplete()  # in lockstep this begins the next one
            if self.settings.clock is Clock.REALTIME:
                self.statistics.late(now_ns - deadline_ns)
            if complete or not self._lockstep:
                self._begin_cycle(deadline_ns)
        else:
            self._deadline_ns = now_ns + self.bring_up.retry_ns
            self._out.extend(self.bring_up.call(now_ns))
            if self.bring_up.problem:
                self._halt(self.bring_up.problem)
        return self._flush()

    def _begin_cycle(self, now_ns: int) -> None:
        """SYNC, and with it all that the master knows of this cycle already."""
        if self._deadline_ns is None:
            return
        self._began_ns = now_ns
        self._deadline_ns = now_ns + self.settings.cycle_limit_ns
        cycle = self.cycle = self.cycle + 1
        state = BUS_STATES[self.phase]
        self._out.append(self.broadcast.sync(cycle, state))
        self._answers.begin(self.phase, cycle)
        if self.phase is Phase.RUN and self._setpoint is not None:
            self.broadcast.setpoint(
                self._setpoint, cycle, self._out, self._displacement, self.force_control.bias
            )
            self.carried = Carried(self.motion.generator.tick_count, cycle, self._now_ns)
        if cycle % HEARTBEAT_EVERY == 0:
            self._beat(state, int(self.fault is not None))

    def _close_incomplete(self) -> None:
        """The cycle's time is over and somebody has not answered."""
        self.statistics.miss(self._answers.describe())
        lost = self._answers.unanswered(self.cycle)
        self._answers.missing = 0
        self._missed(lost)
        self._close()

    def _close(self) -> None:
        """All have answered, or their time is over: change phase, make the next set-point."""
        self.closed += 1
        self.stillness.watch(self.arm_state)
        self._at_close()
        if not self._lockstep or self._deadline_ns is None:
            return
        if self.paced:
            self._deadline_ns = self._began_ns + self.settings.period_ns
        else:
            self._begin_cycle(self._now_ns)

    @property
    def in_progress(self) -> int:
        """The cycle under way; between the close of one and the next SYNC the one that is next."""
        return self.cycle if self._answers.missing else self.cycle + 1
