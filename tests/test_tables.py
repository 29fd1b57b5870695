"""A literal table that leaves a member out is found where it is made."""

from enum import Enum
from itertools import product

import pytest

from rfms_can.errors import RfmsError, TableError
from rfms_can.tables import complete


class Colour(Enum):
    RED = 1
    GREEN = 2


def test_a_complete_table_is_handed_back() -> None:
    table = {Colour.RED: "stop", Colour.GREEN: "go"}
    assert complete(table, Colour) is table


def test_a_missing_member_is_named() -> None:
    with pytest.raises(TableError, match=r"Colour\.GREEN"):
        complete({Colour.RED: "stop"}, Colour)


def test_a_missing_pair_is_named() -> None:
    pairs = list(product(Colour, Colour))
    table = dict.fromkeys(pairs[:-1], 0)
    with pytest.raises(TableError, match=r"\(Colour\.GREEN, Colour\.GREEN\)"):
        complete(table, pairs)


def test_a_missing_word_and_an_unknown_one_are_named() -> None:
    with pytest.raises(TableError, match="'plate'"):
        complete({"free": 0}, ["free", "plate"])
    with pytest.raises(RfmsError, match="'plat'"):
        complete({"free": 0, "plat": 1}, ["free"])
