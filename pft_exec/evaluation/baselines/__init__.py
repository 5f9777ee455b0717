"""What ours is measured against: the paper's hidden Markov model, movement primitives, the nearest demonstration.

Their libraries are the extra `evaluation` of the package; each module imports its own.
"""
