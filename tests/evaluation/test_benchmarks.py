"""The registry of benchmarks: each has a function behind its name, and an unknown one is refused by name."""

from __future__ import annotations

import numpy as np
import pytest

from pft_exec.evaluation.benchmarks import BENCHMARKS, benchmark, synthetic_demonstrations
from pft_exec.exceptions import UnknownNameError


def test_benchmarks_run_by_name_and_answer_with_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BENCHMARKS, "nothing", lambda seed, _: {"nothing": [{"seed": seed}]})
    assert benchmark("nothing", seed=3) == {"tables": {"nothing": [{"seed": 3}]}}
    assert {"learning", "recognition"} <= set(BENCHMARKS)


def test_an_unknown_benchmark_names_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'learning'"):
        benchmark("learnings")


def test_synthetic_demonstrations_are_seeded_and_of_the_asked_size() -> None:
    first, again = synthetic_demonstrations(2, 1, 3, 50), synthetic_demonstrations(2, 1, 3, 50)
    assert [len(item) for item in first] == [50] * 6
    assert all(np.array_equal(a.position, b.position) for a, b in zip(first, again, strict=True))
