"""What the roster finds wrong with a heartbeat."""

import pytest

from rfms_can.master.start_up.roster import Roster
from rfms_can.wire.configuration import plant_hash
from rfms_can.wire.nodes import PLANT
from rfms_can.wire.records import Heartbeat
from rfms_can.wire.vocabulary import NodeState

DBC_HASH = 0x1234
PLANT_HASH = plant_hash(260, 0.004)


def beat(*, dbc: int = DBC_HASH, configuration: int = PLANT_HASH, boot: int = 1) -> Heartbeat:
    return Heartbeat(NodeState.PREOP, 0, 0, boot, dbc, configuration, 0, 0)


def test_a_plant_like_the_master_s_is_welcome_and_so_is_one_that_does_not_tell() -> None:
    roster = Roster(DBC_HASH, PLANT_HASH)
    assert roster.hear(PLANT, beat()) is None
    assert roster.hear(PLANT, beat(configuration=0)) is None


@pytest.mark.parametrize(("arm", "period"), [(560, 0.004), (260, 0.005)])
def test_a_plant_of_another_arm_or_rate_is_refused(arm: int, period: float) -> None:
    wrong = Roster(DBC_HASH, PLANT_HASH).hear(PLANT, beat(configuration=plant_hash(arm, period)))
    assert wrong is not None
    assert "plant carries another arm, or runs at another rate" in wrong
    assert "--arm and --rate" in wrong


def test_another_dbc_and_a_restart_are_named() -> None:
    roster = Roster(DBC_HASH, PLANT_HASH)
    assert "another DBC" in (roster.hear(3, beat(dbc=1)) or "")
    assert roster.hear(4, beat()) is None
    assert "restarted" in (roster.hear(4, beat(boot=2)) or "")
