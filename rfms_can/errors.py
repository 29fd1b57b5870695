"""The error tree. Every message names the value, the bound, the joint or frame, and the way out.

::

    RfmsError
    ├── FrameError          a CAN frame that cannot exist (id, length)
    ├── WireError           the DBC, or a payload that violates it
    │   ├── EncodeError     our own value does not fit its signal: a bug, raised at once
    │   └── DbcError        the DBC file itself is unusable or not the one the bus runs
    ├── BusError            the bus does not exist, or failed
    ├── ArmError            unknown arm, friction set or parameter
    ├── KinematicsError     a pose the arm cannot take
    │   ├── UnreachableError    no solution: outside the shoulder cylinder or the reach
    │   ├── JointLimitError     a solution outside a joint's range
    │   └── SingularityError    a Jacobian that cannot be inverted there
    ├── ProgramError        a request of a user program is refused
    │   ├── TransformError      a transform that is invalid, is unknown, or changes its kind
    │   ├── EquationError       a position equation without exactly one T6, or unsolvable
    │   ├── JointPositionError  joint angles that are not six in their ranges
    │   ├── ModeError           a mode that contradicts itself
    │   ├── MoveError           a move that breaks a rule of the trajectory generator
    │   ├── StoppedError        a move that was stopped or dropped before its goal
    │   ├── TrackingError       a move that stopped short: the arm could not follow its path
    │   └── LeaseError          another coordinator controls the arm, or the lease has lapsed
    ├── LinkError           no server, no answer, or an invalid message
    ├── EngineError         a campaign cannot run as asked: its file, its cluster
    │   └── JobError            one of its jobs failed, or every worker that tried it was lost
    ├── TableError          an incomplete table: a bug, found at import
    ├── PlantError          MuJoCo warned, or the plant was asked for an impossible rate
    └── FaultError          a latched fault has halted the arm: it is safe, and waits for a reset

Nothing a peer puts on the bus raises: nodes discard and count (``PROTOCOL`` R0). These errors are
for our own bugs, for bad input of users, and for drivers.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any


class RfmsError(Exception):
    """Base of all errors of this package."""


class FrameError(RfmsError, ValueError):
    """A CAN frame that cannot exist on the wire."""


class WireError(RfmsError):
    """The wire contract is broken."""


class EncodeError(WireError, ValueError):
    """One of our own values does not fit its signal."""


class DbcError(WireError):
    """The DBC file is unusable, or not the one the rest of the bus runs."""


class BusError(RfmsError):
    """A bus does not exist, does not match its URL, or failed."""


class ArmError(RfmsError, ValueError):
    """An arm, friction set or arm parameter that does not exist or is invalid."""


class KinematicsError(RfmsError):
    """A pose the arm cannot take.

    Attributes:
        remedy: of a move: what of its mode would have to change, by name; empty if unknown.
    """

    remedy: Mapping[str, Any] = MappingProxyType({})


class UnreachableError(KinematicsError):
    """No inverse solution exists."""


class JointLimitError(KinematicsError):
    """A solution outside a joint's range."""


class SingularityError(KinematicsError):
    """The Jacobian cannot be inverted at this pose."""


class ProgramError(RfmsError):
    """A user program's request is refused."""


class EquationError(ProgramError, ValueError):
    """A position equation that cannot be solved for T6."""


class JointPositionError(ProgramError, ValueError):
    """A position in joint coordinates that is not six angles in the ranges of their joints."""


class TransformError(ProgramError, ValueError):
    """A transform that is not rigid, is not defined, or would change its kind."""


class ModeError(ProgramError, ValueError):
    """A mode that contradicts itself."""


class LeaseError(ProgramError):
    """Another coordinator controls the arm, or the lease has lapsed."""


class StoppedError(ProgramError):
    """A move that is waited for was stopped, or dropped from the queue, before its goal."""


class TrackingError(ProgramError):
    """The arm could not follow its path, and has come to rest beside it."""


class LinkError(RfmsError):
    """The link to the server: an address, a key, or a server that does not answer."""


class MoveError(ProgramError, ValueError):
    """A move that breaks a rule of the trajectory generator.

    Attributes:
        remedy: what of its mode would have to change, by name, or ``wait``: the move to wait for.
            It has been tried; empty if nothing is known that would do.
    """

    remedy: Mapping[str, Any] = MappingProxyType({})


class EngineError(RfmsError):
    """A campaign cannot run as asked: its file of results, its workers or its cluster."""


class JobError(EngineError):
    """A job of a campaign failed, or was given up because its workers were lost."""


class TableError(RfmsError, LookupError):
    """One of our own tables has no entry for a member, or one for something else."""


class PlantError(RfmsError):
    """The plant cannot run as asked, or MuJoCo warned."""


class FaultError(RfmsError):
    """A latched fault has halted the arm; without a reset the run has failed."""
