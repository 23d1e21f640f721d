"""Pictures with matplotlib, an extra: `pip install sidestep[plot]`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._sidestep import Plan


def plot(plan: Plan, ax: Any = None, *, trace: bool = True) -> Any:
    """Draws a plan of a robot in the plane with its task, and the iterates where it kept them; returns the axes."""
    from matplotlib import pyplot as plt
    from matplotlib.patches import Circle, Polygon, Rectangle

    task = plan.task
    if task.bounds is None:
        raise ValueError("plan: only tasks in the plane are drawn here; `sidestep plan --png` draws robots with joints")
    if ax is None:
        ax = plt.subplots()[1]
    for kind, points in task.obstacles:
        if kind == "rect":
            (x, y), (right, top) = points
            ax.add_patch(Rectangle((x, y), right - x, top - y, fc="#9fabb7", ec="#4a5763"))
        elif kind == "circle":
            ax.add_patch(Circle(points[0], points[1][0], fc="#9fabb7", ec="#4a5763"))
        else:
            ax.add_patch(Polygon(points, fc="#9fabb7", ec="#4a5763"))
    iterates = plan.trace if trace else None
    if iterates is not None:
        for i, path in enumerate(iterates):
            ax.plot(*path.T, color="#56b4e9", alpha=0.15 + 0.6 * i / max(1, len(iterates) - 1), lw=0.8)
    if plan.waypoints is not None:
        style = "-" if plan.solved else "--"
        ax.plot(*plan.waypoints.T, style, marker=".", color="#0072b2" if plan.solved else "#d55e00", label=plan.status)
    for end, marker in ((task.start, "o"), (task.goal, "D")):
        ax.plot(*end, marker, color="#1f2933")
        if task.robot_radius:
            ax.add_patch(Circle(end, task.robot_radius, fill=False, ec="#1f2933", ls=":"))
    (left, bottom), (right, top) = task.bounds
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", title=repr(plan))
    return ax
