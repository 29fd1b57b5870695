"""The hub as an interface of python-can: ``can.Bus(interface="rfms", channel="NAME")``.

With it candump-like tools attach where the kernel has no CAN::

    can_logger -i rfms -c NAME --fd
    cantools monitor -b rfms -c NAME --fd dbc/rfms.dbc
"""

import time
from typing import Any

import can
from can.typechecking import AutoDetectedConfig, CanFilters

from rfms_can.bus.hub.address import live_hubs
from rfms_can.bus.hub.port import HubPort
from rfms_can.bus.port import LONGEST_WAIT_S
from rfms_can.errors import BusError, FrameError
from rfms_can.wire.frame import Frame


class HubBus(can.BusABC):
    """A hub as a python-can bus; CAN FD, 11-bit data frames only.

    Args:
        channel: the hub's name.
        receive_own_messages: whether to receive the messages of this bus object.
        can_filters: see ``can.BusABC.set_filters``; applied in software.
        kwargs: python-can's arguments of any interface (``fd``, ``bitrate``, ...), which the hub
            determines.

    Raises:
        can.CanInitializationError: no hub of that name is running.
    """

    def __init__(
        self,
        channel: str,
        receive_own_messages: bool = False,
        can_filters: CanFilters | None = None,
        **kwargs: Any,
    ) -> None:
        try:
            self._port = HubPort(str(channel), echo=receive_own_messages, batch=False)
        except BusError as error:
            raise can.CanInitializationError(str(error)) from error
        self.channel_info = f"rfms hub {channel!r}"
        self._channel = str(channel)
        classic = self._port.timing.data_bit_rate is None
        self._can_protocol = can.CanProtocol.CAN_20 if classic else can.CanProtocol.CAN_FD
        super().__init__(channel=channel, can_filters=can_filters, **kwargs)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        try:
            frame = self._port.recv(LONGEST_WAIT_S if timeout is None else max(0.0, timeout))
        except BusError as error:
            raise can.CanOperationError(str(error)) from error
        if frame is None:
            return None, False
        message = can.Message(
            timestamp=time.time(),
            arbitration_id=frame.id,
            is_extended_id=False,
            data=frame.data,
            is_fd=frame.fd,
            bitrate_switch=frame.fd,
            channel=self._channel,
        )
        return message, False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send an 11-bit data frame.

        Raises:
            can.CanOperationError: any other frame, or the hub has gone.
        """
        if msg.is_extended_id or msg.is_remote_frame or msg.is_error_frame:
            raise can.CanOperationError(f"a hub carries 11-bit data frames only, not: {msg}")
        try:
            self._port.send((Frame(msg.arbitration_id, bytes(msg.data), msg.is_fd),))
        except (BusError, FrameError) as error:
            raise can.CanOperationError(str(error)) from error

    def fileno(self) -> int:
        """The socket's descriptor: readable whenever ``recv`` has a message."""
        return self._port.fileno()

    def shutdown(self) -> None:
        """Leave the hub."""
        super().shutdown()
        self._port.close()

    @staticmethod
    def _detect_available_configs() -> list[AutoDetectedConfig]:
        return [{"interface": "rfms", "channel": name} for name in live_hubs()]
