"""The bench of two checkouts: this one beside itself costs the same."""

import json
import subprocess
import sys

import pytest
from support.system import ROOT

TOOL = ROOT / "tools" / "bench_trees.py"


@pytest.mark.system
def test_a_tree_beside_itself_is_measured() -> None:
    command = [sys.executable, str(TOOL), str(ROOT), str(ROOT), "--pairs", "3", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert figures["pairs"] == 3
    assert all(value > 0.0 for value in figures.values())


def test_one_tree_is_one_too_few() -> None:
    command = [sys.executable, str(TOOL), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert "give two checkouts, the old one first" in done.stderr
