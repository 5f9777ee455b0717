"""The log of a run survives its file bit for bit, and anything else is refused."""

from dataclasses import fields

import numpy as np
import pytest

from pft_exec.control import Command
from pft_exec.demonstration.hdf5 import read_file, write_file
from pft_exec.exceptions import StorageError
from pft_exec.execution.control_history import ControlHistory
from pft_exec.execution.log import FORMAT, VERSION, BeliefHistory, ExecutionLog, LogRecorder, Stage


def command(generator: np.random.Generator, index: int) -> Command:
    joints = [generator.normal(size=7) for _ in range(5)]
    return Command(
        *joints,
        position=generator.normal(size=3),
        quaternion=np.array([0.0, 0.0, 0.0, 1.0]),
        phase=0.5,
        error=generator.normal(size=6),
        torque_active=joints[0] > 0.0,
        bound_active=joints[1] > 0.0,
        status="solved" if index < 3 else "nothing found",
        fallback=index >= 3,
        costs={"tracking": 1.0} if index < 3 else {},
        apart_active=("forearm / bottle",) if index == 1 else (),
    )


def recorded(rows: int = 5) -> ExecutionLog:
    generator = np.random.default_rng(1)
    recorder = LogRecorder()
    for index in range(rows):
        joints = {
            name: generator.normal(size=7)
            for name in (
                "configuration",
                "velocity",
                "torque",
                "reference_position",
                "reference_velocity",
                "reference_acceleration",
            )
        }
        recorder.add(
            time=0.001 * index,
            position=generator.normal(size=3),
            quaternion=[0.0, 0.0, 0.0, 1.0],
            phase=np.nan if index < 2 else 0.5,
            stage=Stage.GUIDED if index < 2 else Stage.TUBE,
            hand_force=1.0,
            tick=1e-4,
            command=command(generator, index),
            rate=1.0 - 0.1 * index,
            **joints,
        )
    recorder.belief(0.0, {"reach": 0.4, "go_home": 0.6}, 0.1)
    recorder.event(0.002, "take_over", "go_home at 0.97")
    recorder.event(0.003, "take_over", "again")
    about = {"robot": "pr2", "task": "tabletop", "arm": "left", "label": "go_home", "details": {"end_error": 1e-3}}
    return recorder.finish(True, "the motion was finished", **about)


def test_a_saved_log_is_loaded_bit_for_bit(tmp_path):
    log = recorded()
    log.save(tmp_path / "log.h5")
    loaded = ExecutionLog.load(tmp_path / "log.h5")
    for field in fields(log):
        before, after = getattr(log, field.name), getattr(loaded, field.name)
        if isinstance(before, ControlHistory):
            same_history(before, after)
        elif isinstance(before, BeliefHistory):
            assert before.labels == after.labels
            for name in ("time", "probability", "unknown"):
                np.testing.assert_array_equal(getattr(before, name), getattr(after, name))
        elif isinstance(before, np.ndarray):
            assert before.dtype == after.dtype
            np.testing.assert_array_equal(before, after)
        else:
            assert before == after


def same_history(before: ControlHistory, after: ControlHistory) -> None:
    for field in fields(before):
        value, stored = getattr(before, field.name), getattr(after, field.name)
        if isinstance(value, dict):
            assert value.keys() == stored.keys()
            for name in value:
                np.testing.assert_array_equal(value[name], stored[name])
                assert value[name].dtype == stored[name].dtype
        elif isinstance(value, np.ndarray):
            assert value.dtype == stored.dtype
            np.testing.assert_array_equal(value, stored)
        else:
            assert value == stored


def test_the_control_history_tells_what_each_period_decided():
    history = recorded().control
    assert len(history) == 5
    assert history.statuses == ("solved", "nothing found")
    np.testing.assert_array_equal(history.status, [0, 0, 0, 1, 1])
    np.testing.assert_array_equal(history.fallback, [False, False, False, True, True])
    np.testing.assert_array_equal(history.costs["tracking"], [1.0, 1.0, 1.0, np.nan, np.nan])
    np.testing.assert_array_equal(history.apart["forearm / bottle"], [False, True, False, False, False])
    np.testing.assert_allclose(history.rate, [1.0, 0.9, 0.8, 0.7, 0.6])


def test_a_log_of_the_first_version_is_read_without_a_history(tmp_path):
    log = recorded()
    log.save(tmp_path / "now.h5")
    content = read_file(tmp_path / "now.h5", FORMAT, VERSION)
    del content["control"]
    write_file(tmp_path / "then.h5", content, FORMAT, 1)
    loaded = ExecutionLog.load(tmp_path / "then.h5")
    np.testing.assert_array_equal(loaded.torque, log.torque)
    assert loaded.events == log.events
    assert len(loaded.control) == 0


def test_a_run_without_rows_or_beliefs_is_a_log_too(tmp_path):
    LogRecorder().finish(False, "the scene is out of reach").save(tmp_path / "log.h5")
    loaded = ExecutionLog.load(tmp_path / "log.h5")
    assert len(loaded) == 0
    assert loaded.reason == "the scene is out of reach"
    assert loaded.belief.labels == ()


def test_the_first_event_of_a_name_is_found():
    log = recorded()
    assert log.event("take_over").detail == "go_home at 0.97"
    assert log.event("ask") is None


def test_beliefs_are_kept_in_the_order_of_the_sorted_labels():
    history = recorded().belief
    assert history.labels == ("go_home", "reach")
    np.testing.assert_array_equal(history.probability, [[0.6, 0.4]])


def test_a_log_that_lacks_a_part_is_refused(tmp_path):
    write_file(tmp_path / "log.h5", {"time": np.zeros(3)}, FORMAT, VERSION)
    with pytest.raises(StorageError, match="lacks a part"):
        ExecutionLog.load(tmp_path / "log.h5")


def test_a_file_of_another_kind_is_refused(tmp_path):
    write_file(tmp_path / "other.h5", {}, "something else", 1)
    with pytest.raises(StorageError, match="expected format 'pft_exec execution log'"):
        ExecutionLog.load(tmp_path / "other.h5")
