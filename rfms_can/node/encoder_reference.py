"""Referencing of an incremental encoder by index pulse and coarse position.

Index pulses come once a motor revolution; the coarse position (a potentiometer) identifies the
revolution, the index pulse the exact angle.
"""

from collections.abc import Mapping
from typing import Final

from rfms_can.wire.records import Measure, Reference
from rfms_can.wire.vocabulary import Parameter

AMBIGUITY: Final = 0.25
"""Largest distance of the coarse position from an index, in index intervals, to identify it."""


class EncoderReference:
    """Counts to joint angle (rad), once referenced; before that, a coarse angle.

    Attributes:
        zero_counts: encoder counts at joint angle 0; None while unreferenced.
        residual: distance between coarse and index position, index intervals.
    """

    __slots__ = (
        "_coarse_per_code",
        "_coarse_zero",
        "_counts_per_rad",
        "_interval_counts",
        "residual",
        "zero_counts",
    )

    def __init__(self, parameters: Mapping[Parameter, float]) -> None:
        self._counts_per_rad = parameters[Parameter.COUNTS_PER_UNIT]
        self._interval_counts = round(parameters[Parameter.INDEX_INTERVAL_COUNTS])
        self._coarse_per_code = parameters[Parameter.COARSE_PER_CODE]
        self._coarse_zero = parameters[Parameter.COARSE_ZERO]
        self.zero_counts: int | None = None
        self.residual = 0.0

    def coarse_angle(self, coarse_adc: int) -> float:
        """Joint angle by the coarse position alone, rad."""
        return self._coarse_zero + coarse_adc * self._coarse_per_code

    def angle(self, counts: int) -> float:
        """Joint angle, rad; relative to power-up while unreferenced."""
        return (counts - (self.zero_counts or 0)) / self._counts_per_rad

    def find(self, measure: Measure, reference: Reference) -> bool | None:
        """Try to reference the encoder from one sample of the board.

        Returns:
            None while no index has been seen, True when referenced, False when the coarse position
            is between two indexes: encoder or potentiometer is faulty.
        """
        if not reference.index_valid:
            return None
        coarse = self.coarse_angle(reference.coarse_adc) * self._counts_per_rad
        at_index = coarse - (measure.counts - reference.index_counts)
        turns = round(at_index / self._interval_counts)
        self.residual = abs(at_index / self._interval_counts - turns)
        if self.residual > AMBIGUITY:
            return False
        self.zero_counts = reference.index_counts - turns * self._interval_counts
        return True
