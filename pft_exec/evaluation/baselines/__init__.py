"""What ours is measured against: the paper's hidden Markov model, movement primitives, the nearest demonstration."""

from pft_exec.evaluation.baselines.hmm import HMMClassifier, TiedMixtureHMM, learn_hmm
from pft_exec.evaluation.baselines.nearest_neighbor import NearestNeighbor, learn_nearest_neighbor
from pft_exec.evaluation.baselines.promp import ProMPClassifier, learn_promp

__all__ = [
    "HMMClassifier",
    "NearestNeighbor",
    "ProMPClassifier",
    "TiedMixtureHMM",
    "learn_hmm",
    "learn_nearest_neighbor",
    "learn_promp",
]
