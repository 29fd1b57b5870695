"""The configuration dialogue: one parameter at a time to each node, closed by the hash."""

from collections.abc import Mapping
from typing import Any

from rfms_can.wire.configuration import JOINT_PARAMETERS, configuration_hash
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
        done: the node has confirmed all of it.
        problem: why it did not, or None.
    """

    __slots__ = ("_node", "_sender", "_values", "_waiting", "done", "problem")

    def __init__(
        self, node: int, parameters: Mapping[Parameter, float], sender: Sender[Any]
    ) -> None:
        self._node = node
        self._sender = sender
        self._values = dict(sorted(parameters.items()))
        self._waiting = [*self._values, Parameter.COMMIT]
        self.done = False
        self.problem: str | None = None

    @property
    def hash(self) -> int:
        """The configuration's hash: of all parameters but those the node does not know."""
        return configuration_hash(self._values)

    def current(self) -> Frame:
        """The frame that waits for its acknowledgement; again on request."""
        parameter = self._waiting[0]
        if parameter is Parameter.COMMIT:
            return self._sender.frame(parameter, len(self._values), 0.0, self.hash)
        return self._sender.frame(parameter, 0, self._values[parameter], 0)

    def acknowledge(self, ack: ConfigAck) -> Frame | None:
        """Take an acknowledgement; returns the next frame, or None."""
        parameter = self._waiting[0]
        if self.done or ack.parameter != parameter:
            return None
        value = self._values.get(parameter, 0.0)
        name, text = NODE_NAMES[self._node], parameter.name
        if ack.status == ConfigStatus.UNKNOWN and parameter not in JOINT_PARAMETERS:
            del self._values[parameter]  # a node of an earlier version: its default holds
        elif ack.status != ConfigStatus.TAKEN:
            self.problem = f"{name} refuses {text} = {value:g}: {name_of(ConfigStatus, ack.status)}"
            return None
        elif parameter is Parameter.COMMIT:
            self.done = ack.hash == self.hash
            if not self.done:
                self.problem = f"{name} holds configuration {ack.hash:#06x}, not {self.hash:#06x}"
            return None
        elif ack.value != value:
            self.problem = f"{name} acknowledges {text} = {ack.value:g}, sent was {value:g}"
            return None
        del self._waiting[0]
        return self.current()
