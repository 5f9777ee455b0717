"""Short runs that several tests share: an arm that floats, an arm that is pushed into the bottle."""

from __future__ import annotations

import hashlib

import numpy as np

from pft_exec.demonstration import Scene
from pft_exec.geometry import Array, Pose
from pft_exec.simulation import World


def float_arm(world: World, arm: str, steps: int, damping: float = 0.5) -> None:
    """Gravity compensation with damping, N m s/rad, for so many steps."""
    model = world.arm(arm)
    for _ in range(steps):
        q, v = world.state(arm)
        world.command(arm, model.gravity(q) - model.counterbalance(q) - damping * v)
        world.step()


def disturbed_run(world: World, steps: int = 400) -> str:
    """Push the floating right arm into the bottle and open the gripper; SHA-256 of all states on the way."""
    digest = hashlib.sha256()
    model = world.arm("right")
    world.set_gripper("right", 0.06)
    for step in range(steps):
        q, _ = world.state("right")
        world.command("right", model.gravity(q) - model.counterbalance(q))
        world.push("right", [6.0, 12.0, np.sin(0.02 * step)], [0.0, 0.1, 0.0])
        world.step()
        digest.update(snapshot(world).tobytes())
    return digest.hexdigest()


def snapshot(world: World) -> Array:
    """Joints, velocity of the right arm, objects, time as one array."""
    state = world.record_state()
    return np.concatenate([state.joints, world.state("right")[1], state.objects.ravel(), [state.time]])


def near_bottle(world: World) -> Scene:
    """The scene with the bottle where `disturbed_run` pushes the tool."""
    objects = dict(world.scene.objects)
    pose = objects["bottle"]
    tool = world.tool("right").position
    objects["bottle"] = Pose([tool[0] + 0.06, tool[1] + 0.14, pose.position[2]], pose.quaternion)
    return Scene(objects)
