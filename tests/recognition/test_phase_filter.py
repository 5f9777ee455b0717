from dataclasses import replace

import numpy as np
import pytest

from pft_exec.recognition import OnlineRecognizer
from pft_exec.recognition.phase_filter import PhaseFilter
from pft_exec.recognition.scores import Sample
from pft_exec.recognition.settings import PhaseSettings
from pft_exec.recognition.timing import rate_changes, rate_prior
from tests.recognition.reference_filter import ReferenceFilter
from tests.recognition.tubes import directions, line, star, stream


@pytest.mark.parametrize("turn", [None, [0.0, 0.4, 0.2]])
@pytest.mark.parametrize("spread_start", [9.0, -1.0])
def test_the_kernel_equals_the_plain_sums(turn, spread_start):
    """Evidence, phase, time left, distance and present of each component, also with the mixture over demonstrations."""
    tubes = [*star(3, turn=turn), line("short", [0.3, 0.1, 0.0], steps=40, duration=1.0, turn=turn)]
    filtered = PhaseFilter(tubes, PhaseSettings(spread_start=spread_start, negligible=0.0))
    reference = ReferenceFilter(filtered.model)
    rng, time, before = np.random.default_rng(0), 0.0, 0.0
    for n in range(60):
        state, tempo = tubes[0].at(n / 59), filtered._tempo
        filtered.update(Sample(time, state.position + rng.normal(scale=0.003, size=3), state.quaternion, None, None))
        elapsed = filtered._clock.clock - before
        before += elapsed
        weight = min(filtered.model.evidence_rate * elapsed * tempo, 1.0) if n else filtered.model.first_weight
        now = filtered.model.speeds.at(filtered._clock.direction), filtered._worth_of_present()
        expected = reference.update(filtered._sample, elapsed, weight, *now)
        np.testing.assert_allclose(filtered._out, expected, rtol=1e-9, atol=1e-9)
        time += float(rng.uniform(0.005, 0.06))


def _forked(bend):
    """A line whose last two fifths bend off."""
    tube = line(f"bend {bend:g}", [1.0, 0.0, 0.0])
    off = bend * np.maximum(np.linspace(0.0, 1.0, len(tube)) - 0.6, 0.0)[:, None] * np.array([0.0, 1.0, 0.0])
    aligned = type(tube.aligned)(tube.aligned.position + off, None, tube.aligned.time)
    return replace(tube, position=tube.position + off, aligned=aligned)


def test_a_hand_that_takes_the_other_branch_is_believed_sooner_for_where_it_is_now():
    """Two motions begin alike, and a hand that was a little nearer to the one takes the other: 0.9 comes sooner."""
    tubes, surely = [_forked(0.0), _forked(0.3)], []
    for present in (0.0, 0.5):
        beliefs = stream(OnlineRecognizer(tubes, settings=PhaseSettings(present=present)), tubes[1], bend=(0, -0.01, 0))
        right = [belief.probability[tubes[1].label] > 0.9 for belief in beliefs]
        surely.append(len(right) - int(np.argmin(right[::-1])) if not all(right) else 0)
    assert surely[1] < surely[0] - 2


def test_the_present_sample_does_not_add_up():
    """A hand that stands beside both motions for five seconds is believed no more on either than when it came there."""
    tubes = [line("a", [1.0, 0.0, 0.0]), line("b", [1.0, 0.12, 0.0], seed=1)]
    recognizer, path = OnlineRecognizer(tubes), tubes[0].position
    beliefs = [recognizer.update(0.02 * n, path[min(n, 40)]) for n in range(40 + 250)]
    assert beliefs[-1].probability["a"] == pytest.approx(beliefs[44].probability["a"], abs=0.05)


def test_forgetting_negligible_phases_changes_little():
    """Log likelihood ratio, phase and time left along a motion, with and without: within 0.05, 0.01 and 0.02 s."""
    tubes = [line("a", [1.0, 0.0, 0.0]), line("b", [1.0, 0.12, 0.0], seed=1)]
    lean, full = PhaseFilter(tubes), PhaseFilter(tubes, PhaseSettings(negligible=0.0))
    for n in range(100):
        sample = Sample(0.02 * n, tubes[0].at(n / 99).position, None, None, None)
        first, second = lean.update(sample), full.update(sample)
        difference = np.diff(first.log_likelihood)[0] - np.diff(second.log_likelihood)[0]
        assert abs(difference) < 0.05
        np.testing.assert_allclose(first.phase, second.phase, atol=0.01)
        np.testing.assert_allclose(first.time_to_completion, second.time_to_completion, atol=0.02)


def test_each_motion_is_recognized_early_and_surely():
    """Four directions: the right label leads from the first tenth on, above 0.95 at the end, never 0.95 for another."""
    tubes = star()
    for tube in tubes:
        beliefs = stream(OnlineRecognizer(tubes), tube)
        labels = [belief.label for belief in beliefs]
        assert set(labels[len(labels) // 5 :]) == {tube.label}
        assert beliefs[-1].probability[tube.label] > 0.95
        assert all(b.label == tube.label for b in beliefs if b.probability[b.label] > 0.95)
        assert beliefs[-1].unknown < 0.5


@pytest.mark.parametrize("rate", [20.0, 100.0, 1000.0])
def test_the_rate_of_sampling_hardly_matters(rate):
    """Belief halfway is the same within 0.1 for 20 Hz, 100 Hz and 1 kHz; phase within 0.03."""
    tubes = [line("a", [1.0, 0.0, 0.0]), line("b", [1.0, 0.12, 0.0], seed=1)]
    expected = stream(OnlineRecognizer(tubes), tubes[0], 100.0, until=0.5)[-1]
    belief = stream(OnlineRecognizer(tubes), tubes[0], rate, until=0.5)[-1]
    assert belief.probability["a"] == pytest.approx(expected.probability["a"], abs=0.1)
    assert belief.phase["a"] == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("pace", [0.3, 0.5, 0.7, 1.5, 2.0, 3.0])
def test_other_paces_are_ordinary(pace):
    """A third of the speed to three times: recognized, known, and the time left follows the person's pace."""
    tubes = star()
    beliefs = stream(OnlineRecognizer(tubes), tubes[1], pace=pace, until=0.7)
    assert beliefs[-1].label == "1"
    assert beliefs[-1].probability["1"] > 0.9
    assert beliefs[-1].unknown < 0.3
    assert beliefs[-1].phase["1"] == pytest.approx(0.7, abs=0.08)
    assert beliefs[-1].time_to_completion["1"] == pytest.approx(0.3 * 2.0 / pace, rel=0.4)


@pytest.mark.parametrize("pace", [0.4, 2.5])
def test_a_person_whose_phase_is_found_late_is_less_strange_for_where_the_hand_is(pace):
    """Less strange by a tenth in the odds at least, and a hand beside the tube is nearly as strange as it was."""

    def odds(placing, bend, pace):
        recognizer = OnlineRecognizer(star(), settings=PhaseSettings(placing=placing))
        unknown = stream(recognizer, star()[1], pace=pace, until=0.5, bend=(0.0, 0.0, bend))[-1].unknown
        return unknown / (1.0 - unknown)

    assert odds(0.05, 0.006, pace) < 0.9 * odds(0.0, 0.006, pace)
    assert odds(0.05, 0.1, 1.0) > 0.95 * odds(0.0, 0.1, 1.0)


def test_a_slow_hand_counts_for_no_more_than_a_quick_one():
    """Evidence at the end of a motion and the direction on the way, once the tempo is known."""
    tubes, weights, headings = star(), [], []
    for pace in (0.4, 1.0, 2.5):
        filtered = PhaseFilter(tubes)
        for n in range(round(200 / pace)):
            state = tubes[1].at(min(pace * n / 199, 1.0))
            filtered.update(Sample(0.01 * n, state.position, state.quaternion, None, None))
            if n == round(140 / pace):
                headings.append(np.linalg.norm(filtered._clock.heading))
        weights.append(filtered._weight)
    assert np.allclose(weights, weights[1], rtol=0.4)  # by time alone: 12 and 2 where 4.8 is right
    assert np.allclose(headings, headings[1], rtol=0.1)


def test_changes_of_pace_leave_how_often_each_is_kept_as_it_is():
    """People go from a pace to one beside it, and in the long run keep each as often as the prior says."""
    settings = PhaseSettings()
    prior, change = rate_prior(settings), rate_changes(settings, np.array([0.3]))[0]
    after = change[:, 1] * prior
    after[1:] += change[1:, 0] * prior[:-1]
    after[:-1] += change[:-1, 2] * prior[1:]
    np.testing.assert_allclose(after, prior, rtol=1e-12)
    assert change.min() >= 0.0


def _paused(recognizer, tube, at, seconds):
    """A motion that stands still at phase `at`; beliefs before and after the pause, and at the end."""
    time, beliefs = 0.0, []
    for phase in np.arange(0.0, 1.0, 0.005):
        waits = int(seconds * 100) if abs(phase - at) < 1e-9 else 1
        for _ in range(waits):
            beliefs.append(recognizer.update(time, tube.at(phase).position))
            time += 0.01
        if waits > 1:
            pause = beliefs[-waits], beliefs[-1]
    return *pause, beliefs[-1]


@pytest.mark.parametrize("at", [0.0, 0.4])
def test_a_pause_and_an_idle_start_change_little(at):
    """Five seconds of standing at the start or on the way move the phase by a tenth; the end is still right."""
    tubes = star()
    before, after, end = _paused(OnlineRecognizer(tubes), tubes[2], at, 5.0)
    assert after.phase["2"] == pytest.approx(before.phase["2"], abs=0.11)
    assert end.label == "2"
    assert end.probability["2"] > 0.95


@pytest.mark.parametrize("tremor", [0.0, 3e-4])
@pytest.mark.parametrize("seconds", [2.0, 30.0])
def test_a_long_pause_makes_no_motion_unknown(seconds, tremor):
    """A hand that stands in the middle, trembling by 0.3 mm or not, and then goes on."""
    tubes, rng = star(), np.random.default_rng(5)
    recognizer, tube = OnlineRecognizer(tubes), tubes[2]
    phases = np.concatenate(
        [np.linspace(0.0, 0.5, 100), np.full(round(100 * seconds), 0.5), np.linspace(0.5, 1.0, 100)]
    )
    beliefs = [
        recognizer.update(0.01 * n, tube.at(phase).position + rng.normal(scale=tremor + 1e-6, size=3))
        for n, phase in enumerate(phases)
    ]
    assert max(belief.unknown for belief in beliefs) < 0.3
    assert beliefs[-1].label == tube.label
    assert beliefs[-101].phase[tube.label] == pytest.approx(0.5, abs=0.11)


def test_nothing_is_believed_before_the_hand_moves():
    """A hand at the common start: all motions stay alike."""
    recognizer = OnlineRecognizer(star())
    for n in range(200):
        belief = recognizer.update(0.01 * n, [0.0, 0.0, 0.0])
    assert max(belief.probability.values()) < 0.4
    assert belief.unknown < 0.5


def test_phase_and_time_left_follow_the_motion():
    """Phase rises to 1 and time to completion falls to 0."""
    tubes = star()
    beliefs = stream(OnlineRecognizer(tubes), tubes[0])
    phase = np.array([b.phase["0"] for b in beliefs])
    left = np.array([b.time_to_completion["0"] for b in beliefs])
    truth = np.linspace(0.0, 1.0, len(beliefs))
    assert np.abs(phase - truth)[20:].max() < 0.1
    assert phase[-1] > 0.93
    assert left[-1] < 0.2
    assert np.abs(left - 2.0 * (1.0 - truth))[20:].max() < 0.4


def test_a_strange_motion_is_called_unknown():
    """A motion between the directions of the library, and well off it, ends as unknown; a known one does not."""
    tubes = star()
    strange = line("strange", [0.5, 0.5, 0.6], seed=9)
    assert stream(OnlineRecognizer(tubes), strange)[-1].unknown > 0.6
    assert stream(OnlineRecognizer(tubes), tubes[3])[-1].unknown < 0.3


@pytest.mark.parametrize("deviation", [0.0, 1e-6, 1e-4])
def test_a_motion_that_a_machine_demonstrated_is_not_unknown(deviation):
    """Demonstrations that agree better than the floor do not make a stream as good as theirs a strange one."""
    tubes = [line(str(k), d, aligned=5, seed=k, deviation=max(deviation, 1e-9)) for k, d in enumerate(directions(3))]
    recognizer = OnlineRecognizer(tubes)
    rng = np.random.default_rng(1)
    for time, position in zip(tubes[0].time, tubes[0].position, strict=True):
        belief = recognizer.update(1.1 * time, position + rng.normal(scale=1e-4, size=3))
    assert belief.label == "0"
    assert belief.unknown < 0.3


def test_orientation_alone_tells_motions_apart():
    """The same path, turned about different axes."""
    tubes = [line("roll", [1.0, 0.0, 0.0], turn=[1.0, 0.0, 0.0]), line("yaw", [1.0, 0.0, 0.0], turn=[0.0, 0.0, 1.0])]
    for tube in tubes:
        belief = stream(OnlineRecognizer(tubes), tube)[-1]
        assert belief.probability[tube.label] > 0.95
    blind = stream(OnlineRecognizer(tubes), tubes[0], turned=False)[-1]
    assert blind.probability["roll"] == pytest.approx(0.5, abs=0.1)


def test_the_sign_of_a_quaternion_does_not_matter():
    """q and -q are the same orientation."""
    tubes = [line("roll", [1.0, 0.0, 0.0], turn=[1.0, 0.0, 0.0]), line("yaw", [1.0, 0.0, 0.0], turn=[0.0, 0.0, 1.0])]
    plain, flipped = OnlineRecognizer(tubes), OnlineRecognizer(tubes)
    for n in range(100):
        state = tubes[0].at(n / 99)
        sign = -1.0 if n % 3 else 1.0
        first = plain.update(0.02 * n, state.position, state.quaternion)
        second = flipped.update(0.02 * n, state.position, sign * state.quaternion)
    assert first.probability["roll"] == pytest.approx(second.probability["roll"], abs=1e-12)


def test_tubes_from_plain_arrays_work():
    """Without demonstrations behind them, tubes get defaults for timing and direction."""
    tubes = star(aligned=0)
    beliefs = stream(OnlineRecognizer(tubes), tubes[1])
    assert beliefs[-1].label == "1"
    assert beliefs[-1].probability["1"] > 0.9
    assert beliefs[-1].phase["1"] > 0.9


@pytest.mark.parametrize("scale", [0.001, 1000.0])
def test_a_change_of_units_changes_no_belief(scale):
    """Millimeters, meters, kilometers; within what the floors in extents allow."""
    tubes, scaled = star(), []
    for tube in tubes:
        aligned = type(tube.aligned)(tube.aligned.position * scale, None, tube.aligned.time)
        scaled.append(
            type(tube)(
                tube.label, tube.time, tube.position * scale, None, tube.covariance * scale**2, tube.time_deviation,
                count=5, aligned=aligned,
            )
        )  # fmt: skip
    bend = np.array([0.0, 0.0, 0.006])
    first = stream(OnlineRecognizer(tubes), tubes[0], until=0.4, bend=bend)[-1]
    second = stream(OnlineRecognizer(scaled), scaled[0], until=0.4, bend=bend * scale)[-1]
    for label in first.probability:
        assert first.probability[label] == pytest.approx(second.probability[label], abs=1e-6)


def test_planar_motions_leave_out_the_axis_that_never_varies():
    """In a library where all lies in z = 0, a sample off the plane says nothing."""
    tubes = [line(str(k), d, aligned=0) for k, d in enumerate(np.eye(3)[:2])]
    flat, lifted = OnlineRecognizer(tubes), OnlineRecognizer(tubes)
    for n in range(50):
        place = tubes[0].at(n / 99).position
        first = flat.update(0.02 * n, place)
        second = lifted.update(0.02 * n, place + np.array([0.0, 0.0, 1e-3 * (n > 0)]))
    assert first.probability["0"] > 0.9
    assert second.probability["0"] == pytest.approx(first.probability["0"], abs=0.05)


def test_the_mixture_over_demonstrations_finds_a_second_start():
    """Where one motion starts in two places, a stream from either is recognized."""
    tubes = []
    for label, direction in (("a", [1.0, 0.0, 0.0]), ("b", [0.0, 1.0, 0.0])):
        tube = line(label, direction)
        shift = np.where(np.arange(5)[:, None, None] < 3, 0.1, -0.1) * np.array([0.0, 0.0, 1.0])
        aligned = type(tube.aligned)(tube.aligned.position + shift, None, tube.aligned.time)
        covariance = tube.covariance + np.diag([0.0, 0.0, 0.01])
        tubes.append(type(tube)(label, tube.time, tube.position, None, covariance, count=5, aligned=aligned))
    recognizer = OnlineRecognizer(tubes)
    assert len(recognizer._method.model.tube) == 2 + 10
    for n in range(100):
        belief = recognizer.update(0.02 * n, tubes[1].at(n / 99).position + np.array([0.0, 0.0, 0.1]))
    assert belief.probability["b"] > 0.95


def test_state_does_not_grow():
    """Memory after 10 and after 2000 samples is the same."""
    filtered, sizes = PhaseFilter(star()), []
    for n in range(2000):
        filtered.update(Sample(0.001 * n, np.array([1e-4 * n, 0.0, 0.0]), None, None, None))
        if n in (10, 1999):
            sizes.append(sum(v.nbytes for v in vars(filtered).values() if isinstance(v, np.ndarray)))
    assert sizes[0] == sizes[1]


def test_a_gap_in_the_stream_is_bridged():
    """A second without samples in the middle of a motion of two."""
    tubes, recognizer = star(), OnlineRecognizer(star())
    for n in [*range(20), *range(70, 100)]:
        belief = recognizer.update(0.02 * n, tubes[2].at(n / 99).position)
    assert belief.label == "2"
    assert belief.phase["2"] > 0.85
