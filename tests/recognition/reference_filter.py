"""The phase filter's kernel written out in plain numpy, one tube after another. Slow on purpose."""

from __future__ import annotations

import numpy as np

from pft_exec.recognition.settings import DEFAULT_SETTINGS


class ReferenceFilter:
    """The same sums as `pft_exec.recognition.phase_kernel`, without dropping negligible states."""

    def __init__(self, model, settings=DEFAULT_SETTINGS):
        self.model = model
        self.placing = settings.placing
        self.parts = [slice(o, o + n) for o, n in zip(model.offset, model.length, strict=True)]
        self.state = [np.zeros((len(model.prior), n)) for n in model.length]
        for state in self.state:
            state[:, 0] = model.prior
        self.pending = np.zeros(len(self.parts))

    def update(self, row, elapsed, weight, speed, present):
        """Log evidence, phase, time left, mean distance and what the sample says now, of each component: (5, J)."""
        results = []
        for j, part in enumerate(self.parts):
            self.pending[j] += elapsed
            while self.pending[j] >= self.model.tick[j]:
                self.pending[j] -= self.model.tick[j]
                self.state[j] = self.predict(j)
            results.append(self.correct(j, part, row, weight, speed[part], present))
        return np.array(results).T

    def predict(self, j):
        model, state = self.model, self.state[j]
        slower, same, faster = model.change[j].T[:, :, None]
        mixed = same * state
        mixed[1:] += slower[1:] * state[:-1]
        mixed[:-1] += faster[:-1] * state[1:]
        after = np.zeros_like(state)
        count = state.shape[1]
        for r in range(len(mixed)):
            step = model.steps[j, r]
            leave = (1.0 - model.idle[j]) / (1.0 - step[0])
            for i in range(count):
                for s in range(6):
                    share = step[s] if i > 0 else (model.idle[j] if s == 0 else leave * step[s])
                    after[r, min(i + s, count - 1)] += share * mixed[r, i]
        return after

    def correct(self, j, part, row, weight, speed, present):
        model = self.model
        square = self.squares(part, row)
        turned = bool(np.any(row[6:]))
        heard = np.zeros(0, dtype=bool)
        size = model.size(turned, heard)
        spent = 0.5 * (model.freedom[j] + size) * np.log1p(square / model.freedom[j])
        density = model.log_scale(turned, heard)[part] - spent
        joint = self.state[j] * np.exp(weight * density)
        total = joint.sum()
        self.state[j] = joint / total
        mass = self.state[j].sum(axis=0)
        steps = np.arange(len(mass))
        likely = mass * np.exp(self.placing * density)
        distance = likely @ spent / likely.sum()
        now = np.log(mass @ (np.exp(present * density) * speed))
        return np.log(total), mass @ steps / (len(mass) - 1), mass @ model.left[part], distance, now

    def squares(self, part, row):
        model = self.model
        place, heading = row[:3, None] - model.mean[:3, part], row[3:6, None] - model.mean[3:, part]
        expected = np.einsum("ijn,jn->in", model.gain[:, part].reshape(3, 3, -1), place)
        residuals = [place, heading - expected]
        if np.any(row[6:]):
            residuals.append(chords(model.turned[:, part].T, row[6:]).T)
        total = 0.0
        for block, residual in enumerate(residuals):
            white = model.white[6 * block : 6 * block + 6, part]
            factor = np.zeros((white.shape[1], 3, 3))
            factor[:, [0, 1, 1, 2, 2, 2], [0, 0, 1, 0, 1, 2]] = white.T
            total = total + (np.einsum("nij,jn->ni", factor, residual) ** 2).sum(axis=1)
        return total


def chords(means, quaternion):
    """Twice the vector parts of mean^-1 * quaternion, in the half space of the identity: (N, 3)."""
    result = []
    for x, y, z, w in means:
        left = np.array([[w, z, -y, -x], [-z, w, x, -y], [y, -x, w, -z], [x, y, z, w]])
        product = left @ quaternion
        result.append(2.0 * product[:3] * (1.0 if product[3] >= 0.0 else -1.0))
    return np.array(result)
