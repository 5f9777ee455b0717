"""The benchmark of compliance: the floors hold with the tube's gains, and constant gains know no wide and narrow."""

from __future__ import annotations

import pytest

from pft_exec.evaluation.benchmarks import compliance
from pft_exec.evaluation.protocol import silent

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tables():
    return list(compliance.measure_compliance(0, silent).values())


def test_a_push_moves_the_tool_far_where_the_tube_is_wide_and_little_where_it_is_narrow(tables):
    tube, *_, constant, _ = tables[0]
    assert tube["ratio"] >= 5.0
    assert tube["static ratio"] >= 6.0
    assert constant["ratio"] < 1.5


def test_the_tool_comes_back_in_time(tables):
    tube = tables[0][0]
    assert tube["recovery wide s"] <= 0.6
    assert tube["recovery narrow s"] <= 0.2


def test_the_end_is_met_although_friction_or_payload_are_wrong(tables):
    tube = tables[1][0]
    assert tube["friction 20 % wrong mm"] <= 2.5
    assert tube["payload 0.5 kg unknown mm"] <= 6.0
