"""Settings of the phase filter: every constant in one place, with what it is worth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PhaseSettings:
    """Constants of ``method="phase"``; found on recordings of people, then left alone.

    Parameters
    ----------
    evidence : float
        Independent observations that a whole motion is worth; neighboring samples are correlated, and a filter that
        counts each of them is far too sure of itself (expected calibration error 16 % instead of 4 %).
    first_evidence : float
        Of them, what the first sample is worth.
    present : float
        Independent observations that the present sample is worth beside its share of the motion's: about one half for a
        residual that changes like an Ornstein-Uhlenbeck process (see `phase_filter`); 0.4 to 0.8 serve as well. It is
        worth half of that where no more than that was seen so far.
    placing : float
        Independent observations that the present sample is worth for where along a tube the hand is, as far as its
        distance from the tube is asked. The evidence alone finds the phase of a person of another tempo late, and the
        lag looked like a strange motion. With more, strange letters find a place that suits them: 0.1 costs 0.006 of
        the area under the curve of unknown ones.
    window : float
        Over which the direction of motion is taken at least, as a share of the median duration.
    noise_window : float
        The same share for noise of one extent; the window grows as the square root of the noise (see `roughness`).
        A fixed window of 0.03 is 0.2 points of share worse on clean recordings of people, one of 0.02 almost a point
        on the same with noise of 0.005 extents.
    direction_weight, direction_softness : float
        How many extents a turn of 1 rad of the direction counts; below which displacement (in extents) it fades.
    prior_strength : float
        Degrees of freedom of the normal-inverse-Wishart prior around the pooled variance profile.
    most_freedom : float
        Of the Student t, however many demonstrations there are (8 is that of five of them): they say how wide a tube
        is, not that people, and tubes of new scenes, err as a Gaussian does.
    floor : float
        Standard deviation that no position undercuts, in extents. A large one blinds the first tenth of a motion.
    rotation_floor, signal_floor : float
        The same for orientation (rad) and for continuous signals (in pooled ranges).
    step_pseudo_count : float
        Steps of the pooled distribution that each motion's own step distribution starts from.
    rates : tuple of float
        Paces, beside the tube's own, that a person may keep for a while, slowest first. Without them each step is
        independent, and the filter takes a slow person for another motion, with great confidence.
    rate_deviation : float
        Of the logarithm of the pace. The recordings that the constants were found on all last equally long and would
        have a narrower one: 0.25 is worth 0.1 points of share there, and costs half a point where people are half as
        fast again.
    rate_tail : float
        What any pace is worth beside the tube's own, however far from it: a person has a pace of their own, which five
        demonstrations of another do not show. Without it, one three times as slow was called unknown.
    rate_memory : float
        Share of a motion after which people change to a neighboring pace. Were any pace as near as any other, those
        that are far from the tube's own would have to be found anew each time.
    tempo_held : float
        Of a motion at the tube's own pace that a person's tempo is estimated from, besides what was seen.
    idle : float
        Probability of staying at the very start for one step of 1 / 200 of the motion.
    leash : float
        Movement that may be tremor, in extents: a hand that stays within it stands.
    patience : float
        Share of the median duration after which a hand that stands stops the motion's clock.
    standing_clock : float
        Pace of that clock then.
    negligible : float
        Probability of a phase, given the motion, at and below which it is forgotten; 0 keeps all.
    spread_start : float
        Start spread, in extents, from which on half the evidence comes from a mixture over demonstrations.
    start_evidence : float
        Independent observations that the place of the first sample is worth: starts of five demonstrations are few, and
        which of them are relevant may be wrong.
    pause : float
        Probability that the speed at any moment is not the motion's own: a pause, or a hurry.
    speed_deviation : float
        Of the logarithm of speed, between people and scenes beside that between a motion's demonstrations.
    rest : float
        Probability that a hand at the last step is coming to rest or rests, whatever its speed in the demonstrations:
        they are cut where they end, a person's stream is not. It falls towards earlier steps as `ending` says.
    """

    evidence: float = 5.0
    first_evidence: float = 0.05
    present: float = 0.6
    placing: float = 0.05
    window: float = 0.02
    noise_window: float = 0.65
    direction_weight: float = 0.4
    direction_softness: float = 0.01
    prior_strength: float = 4.0
    most_freedom: float = 8.0
    floor: float = 0.002
    rotation_floor: float = 0.01
    signal_floor: float = 0.01
    step_pseudo_count: float = 20.0
    rates: tuple[float, ...] = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.9, 4.0)
    rate_deviation: float = 0.3
    rate_tail: float = 0.03
    rate_memory: float = 0.05
    tempo_held: float = 0.15
    idle: float = 0.85
    leash: float = 0.003
    patience: float = 0.04
    standing_clock: float = 0.02
    negligible: float = 1e-6
    spread_start: float = 0.05
    start_evidence: float = 0.2
    pause: float = 0.02
    speed_deviation: float = 0.5
    rest: float = 0.5


DEFAULT_SETTINGS = PhaseSettings()
