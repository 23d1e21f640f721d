"""Optimisation-based motion planning with classical and learned optimizers.

    task = sidestep.suite("hard", 1, seed=3)[0]
    plan = sidestep.plan(task, "sidestep-1")
    plan.waypoints        # float64 [points, 2], proved free of collision

A plan whose status is "solved" is certified: every motion between its waypoints is proved free of collision.
Training environments are in `sidestep.gym`, with Stable-Baselines3 in `sidestep.sb3`; policies go to other programs by
`sidestep.onnx` and `sidestep.torch`; `sidestep.sweep` runs experiments on a Ray cluster.
"""

from ._sidestep import VERSION as __version__
from ._sidestep import (
    Batch,
    Objective,
    Plan,
    Policy,
    Robot,
    Scene,
    Task,
    certify,
    distances,
    plan,
    plan_batch,
    planners,
    read,
    read_problems,
    shortest_path,
    suite,
    write,
)
from .pictures import plot

__all__ = [
    "Batch",
    "Objective",
    "Plan",
    "Policy",
    "Robot",
    "Scene",
    "Task",
    "__version__",
    "certify",
    "distances",
    "plan",
    "plan_batch",
    "planners",
    "plot",
    "read",
    "read_problems",
    "shortest_path",
    "suite",
    "write",
]
