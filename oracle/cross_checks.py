"""Second computations that the exact golden values are held against before they are written."""

import numpy as np
import shapely
from shapely.ops import unary_union

from union_boundary import corners

worst = {"shapely": 0.0, "distance gradient": 0.0, "objective gradient": 0.0, "clearance": 0.0}


def note(what, errors, limit):
    """Keeps the largest error seen and refuses one past `limit`."""
    error = float(np.max(errors, initial=0.0))
    worst[what] = max(worst[what], error)
    if error > limit:
        raise AssertionError(f"{what}: off by {error}, allowed {limit}")


def shapely_union(obstacles):
    """The union with circles as fine polygons: 4096 edges per quarter, so rims are off by less than 1e-6."""
    return unary_union([
        shapely.Point(o["circle"]["center"]).buffer(o["circle"]["radius"], quad_segs=4096) if "circle" in o
        else shapely.Polygon(corners(o))
        for o in obstacles
    ])  # fmt: skip


def check_distance(space, points, distance, gradient, smooth):
    """Distances against shapely, gradients of smooth points against central differences."""
    wall = np.minimum(points - space.lower, space.upper - points).min(axis=1)
    expected = wall
    if space.obstacles:
        union = shapely_union(space.obstacles)
        dots = shapely.points(points)
        signed = np.where(shapely.contains(union, dots), -1.0, 1.0) * shapely.distance(union.boundary, dots)
        expected = np.minimum(wall, signed)
    note("shapely", np.abs(distance - (expected - space.robot_radius)), 1e-5)
    width = 1e-5
    for axis in (0, 1):
        shift = width * np.eye(2)[axis]
        slope = (space.distance(points + shift)[0] - space.distance(points - shift)[0]) / (2 * width)
        note("distance gradient", np.abs(slope - gradient[:, axis])[smooth], 1e-5)


def check_gradient(objective, waypoints, gradient):
    """The objective's gradient against central differences."""
    note("objective gradient", np.abs(objective.central_difference(waypoints) - gradient), 1e-5)


def check_clearance(space, vertices, clearance):
    """The path's clearance against the least distance over 2000 points per segment, never below it."""
    fraction = np.linspace(0, 1, 2000)[None, :, None]
    walk = ((1 - fraction) * vertices[:-1, None] + fraction * vertices[1:, None]).reshape(-1, 2)
    sampled = space.distance(walk)[0].min()
    if clearance is None:
        note("clearance", max(sampled, 0.0), 0.02)
    else:
        note("clearance", abs(sampled - clearance), 0.02)
        if sampled < clearance - 1e-9:
            raise AssertionError(f"clearance {clearance} above the sampled {sampled}")
