"""The configuration dialogue: one parameter at a time to each node, closed by the hash."""

from collections.abc import Mapping
from typing import Any

from rfms_can.wire.configuration import configuration_hash
from rfms_can.wire.frame import Frame
from rfms_can.wire.nodes import NODE_NAMES
from rfms_can.wire.protection import Sender
from rfms_can.wire.records import ConfigAck
from rfms_can.wire.vocabulary import ConfigStatus, Parameter, name_of


class Configurator:
    """Takes one node through its parameters.

    Args:
        node: node number.
        parameters: what it shall hold.
        sender: packs its CONFIG frames.

    Attributes:
        hash: the configuration's hash, which the node must confirm.
        done: the node has confirmed all of it.
        problem: why it did not, or None.
    """

    __slots__ = ("_node", "_pending", "_sender", "_steps", "done", "hash", "problem")

    def __init__(
        self, node: int, parameters: Mapping[Parameter, float], sender: Sender[Any]
    ) -> None:
        self._node = node
        self._sender = sender
        self.hash = configuration_hash(parameters)
        commit = (int(Parameter.COMMIT), len(parameters), 0.0, self.hash)
        self._steps = [
            *((int(p), 0, value, 0) for p, value in sorted(parameters.items())),
            commit,
        ]
        self._pending = 0
        self.done = False
        self.problem: str | None = None

    def current(self) -> Frame:
        """The frame that waits for its acknowledgement; again on request."""
        return self._sender.frame(*self._steps[self._pending])

    def acknowledge(self, ack: ConfigAck) -> Frame | None:
        """Take an acknowledgement; returns the next frame, or None."""
        parameter, _, value, digest = self._steps[self._pending]
        if self.done or ack.parameter != parameter:
            return None
        name, text = NODE_NAMES[self._node], Parameter(parameter).name
        if ack.status != ConfigStatus.TAKEN:
            self.problem = f"{name} refuses {text} = {value:g}: {name_of(ConfigStatus, ack.status)}"
            return None
        if parameter == Parameter.COMMIT:
            self.done = ack.hash == digest
            if not self.done:
                self.problem = f"{name} holds configuration {ack.hash:#06x}, not {digest:#06x}"
            return None
        self._pending += 1
        return self.current()
