r"""Pads: the rubber faces of a gripper's fingers, and what of them the engine is told.

The engine knows rigid faces. Where a flat pad lies on a flat side it finds the corners of the patch in which they meet,
and leaves open how the press is shared between them: one corner of either pad may come to bear it all, and then nothing
but the torsional friction of two points keeps what is held from turning about the line between them. With a solver that
treats friction as a pyramid (`Engine.clear`, with liquid) the engine leaves torsional friction out. A bottle that is
held below its middle then tips like an inverted pendulum (measured: 0.04 to 0.55 rad in a pour).

Rubber shares the press out evenly: a pad of thickness h, area A and Young's modulus E gives way as a spring of E A / h.
A contact point of the engine stands for its share of the patch. With the press on all four corners, sliding friction
alone resists a turn about the axis through the pads, up to ``mu F r``, r the corners' mean distance from the middle.
"""

from __future__ import annotations

import pybullet

FRICTION = 1.0
"""Of the fingers; the engine multiplies it with the object's: rubber pads hold from 0.8 on (measured)."""

STIFFNESS = 5e4
"""N/m of one contact point; grade C. Silicone rubber of 50 Shore A (E about 2.5 MPa), 3 mm thick (a guess), on the 25
by 22 mm in which a pad meets a side of the bottle: E A / h = 4.6e5 N/m, and the engine has eight points there, four
corners that the neighboring sides of the bottle share. Measured: 3e4 to 1e5 hold alike; 1e6 shares hardly better than
rigid faces."""

DAMPING = 200.0
"""N s/m of one contact point: rubber of a time constant of 4 ms; fingers do not bounce."""

SPINNING = 0.003
r"""m; times the press, the torque with which one contact resists turning about its normal. A rubber line of
length l = 22 mm, which is how a pad meets a round bottle, under even press:
``mu F 2/l int_0^{l/2} z dz = mu F l/4``, so l / 4 = 5.5 mm. The engine adds up
``s_1 mu_2 + s_2 mu_1`` of two bodies, which are alike here: s = l / 8 = 2.75 mm."""


def make_pad(client: int, body: int, link: int) -> None:
    """Give a link of a body, in an engine's client, the surface of a pad."""
    pybullet.changeDynamics(
        body,
        link,
        lateralFriction=FRICTION,
        spinningFriction=SPINNING,
        contactStiffness=STIFFNESS,
        contactDamping=DAMPING,
        physicsClientId=client,
    )
