"""What ours is measured against: the paper's hidden Markov model, movement primitives, the nearest demonstration.

Above them stands a bound for the planar world: the `oracle`, which is told how its people move.

Their libraries are the extra `evaluation` of the package; each module imports its own.
"""
