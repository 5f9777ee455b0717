"""Algorithm 4 of [Dong2012]_ written out: full matrices, and the path walked back at each sample. Slow on purpose."""

from __future__ import annotations

import numpy as np

from pft_exec.geometry import relative_rotation_vector


def score_by_full_matrix(tube, share, positions, quaternions, times, time_floor=0.02, distance_floor=1e-9):
    """Log likelihoods (T,) and steps n* (T,) of one tube after each of T samples."""
    cost = np.array([raw_distances(tube, p, q) for p, q in zip(positions, quaternions, strict=True)]).T
    total = cumulative(cost)
    deviation = np.maximum(tube.time_deviation, max(time_floor * tube.duration, 1e-9))
    scores, matches = [], []
    for now in range(len(times)):
        log_density = -0.5 * ((times[now] - tube.time) / deviation) ** 2 - np.log(deviation)
        match = int(np.argmin(np.log(np.maximum(cost[:, now], distance_floor)) - log_density))
        path = walk_back(total, match, now)
        terms = [
            log_likelihood(tube, n, positions[m], None if tube.quaternion is None else quaternions[m]) for n, m in path
        ]
        scores.append(np.log(share * (match + 1) / len(tube)) + np.mean(terms))
        matches.append(match)
    return np.array(scores), np.array(matches)


def raw_distances(tube, position, quaternion):
    square = ((position - tube.position) ** 2).sum(axis=1)
    if tube.quaternion is not None:
        sign = np.where(tube.quaternion @ quaternion < 0.0, -1.0, 1.0)[:, None]
        square = square + ((sign * quaternion - tube.quaternion) ** 2).sum(axis=1)
    return np.sqrt(square)


def cumulative(cost):
    total = np.full(cost.shape, np.inf)
    for n in range(cost.shape[0]):
        for m in range(cost.shape[1]):
            before = [total[i, j] for i, j in predecessors(n, m)]
            total[n, m] = cost[n, m] + (min(before) if before else 0.0)
    return total


def predecessors(n, m):
    """Diagonal, then tube, then time: the order in which ties are broken."""
    return [(i, j) for i, j in ((n - 1, m - 1), (n - 1, m), (n, m - 1)) if i >= 0 and j >= 0]


def walk_back(total, n, m):
    path = [(n, m)]
    while (n, m) != (0, 0):
        n, m = min(predecessors(n, m), key=lambda place: total[place])
        path.append((n, m))
    return path


def log_likelihood(tube, n, position, quaternion):
    delta = position - tube.position[n]
    if quaternion is not None:
        delta = np.concatenate([delta, relative_rotation_vector(tube.quaternion[n], quaternion)])
    return tube.log_normalizer[n] - 0.5 * delta @ tube.precision[n] @ delta
