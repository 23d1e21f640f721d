"""Optimisation-based motion planning with classical and learned optimizers.

    task = sidestep.suite("hard", 1, seed=3)[0]
    plan = sidestep.plan(task, "sidestep-1")
    plan.waypoints        # float64 [points, 2], proved free of collision

A plan whose status is "solved" is certified: every motion between its waypoints is proved free of collision.
Training environments are in `sidestep.gym` and `sidestep.sb3`.
"""

from ._sidestep import VERSION as __version__
from ._sidestep import (
    Batch,
    Objective,
    Plan,
    Task,
    certify,
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
    "Task",
    "__version__",
    "certify",
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
