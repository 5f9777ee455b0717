"""The hand: the synthetic person of the simulation, the path planned for it, how it leads, lets go and takes back.

Nothing that learns, recognizes or decides reads anything in here but the samples that the arm measures.
"""
