"""The corrected objective: exact signed distance, the paper's cost formula, normalised units, in float64.

Distance, in task units: D(u) = min(D_union(u), D_wall(u)) - robot radius. D_union is the distance to the boundary of the union of
all obstacles, negative inside it (also where obstacles overlap). D_wall is the least of the four differences to the sides of the
bounds, so it is negative outside them.

Objective, in normalised coordinates x = (u - lower bound) / scale, scale = the bounds' longer side / 6.4:

    c(D)   = eps/2 - D (D <= 0),  (D - eps)^2 / (2 eps) (0 < D <= eps),  0 beyond, with D in normalised units
    F_obs  = 1/N sum_i c(x_i) + 1/((N+1) S) sum_i sum_j c(x_j^{i,i+1})
    F_len  = sum_i |x_{i+1} - x_i|^2
    U      = F_obs + lambda F_len

(the paper's formulas, section I.A, word for word). Substep j of S lies at fraction j / (S+1) of its segment. The gradient of D is
the unit vector from the nearest boundary point (outside) or towards it (inside). Where two boundary points in clearly different
directions are about equally near, D has a kink, and its gradient is not a fact to test; `smooth` marks the other points.
"""

import numpy as np
import shapely

from paper_profile import substep_points
from union_boundary import corners, covered, covers, union_boundary

NORMALISED_EXTENT = 6.4
KINK_GAP = 2e-4  # task units by which the runner-up must lose
KINK_COSINE = 0.9995  # directions closer than this (0.03 rad) do not make a kink


class Space:
    """Bounds, obstacles and a robot disc."""

    def __init__(self, bounds, obstacles, robot_radius=0.0):
        self.lower, self.upper = np.array(bounds, dtype=float)
        self.obstacles, self.robot_radius = obstacles, robot_radius
        self.scale = (self.upper - self.lower).max() / NORMALISED_EXTENT
        self.boundary = union_boundary(obstacles)

    def distance(self, points):
        """D [M], its gradient [M, 2] and `smooth` [M] at points [M, 2], all in task units."""
        values, directions = [], []
        inside = covered(self.obstacles, points)
        sign = np.where(inside, -1.0, 1.0)
        for piece in self.boundary:
            offset = points - piece.nearest(points)
            length = np.linalg.norm(offset, axis=1)
            values.append(sign * length)
            directions.append((sign / np.maximum(length, 1e-300))[:, None] * offset)
        # Inside the union the nearest boundary point is the one with the greatest (least negative) value.
        if values:
            union, pull, union_smooth = _extreme(np.array(values), np.array(directions), sign)
        else:
            union, pull = np.full(len(points), np.inf), np.zeros((len(points), 2))
            union_smooth = np.ones(len(points), dtype=bool)
        sides = np.concatenate([(points - self.lower).T, (self.upper - points).T])
        normals = np.repeat(np.array([[1, 0], [0, 1], [-1, 0], [0, -1]], dtype=float)[:, None], len(points), axis=1)
        wall, push, wall_smooth = _extreme(sides, normals, np.ones(len(points)))
        nearer = union < wall
        smooth = np.where(nearer, union_smooth & (np.abs(union) > KINK_GAP), wall_smooth)
        smooth &= np.abs(union - wall) > KINK_GAP
        return np.minimum(union, wall) - self.robot_radius, np.where(nearer[:, None], pull, push), smooth

    def to_task(self, normalised):
        """Task units of normalised coordinates."""
        return self.lower + self.scale * normalised

    def to_normalised(self, task):
        """Normalised coordinates of task units."""
        return (np.asarray(task) - self.lower) / self.scale

    def clearance(self, vertices):
        """Least D along the polyline `vertices` [M, 2] (task units), or None where it touches an obstacle or leaves the bounds."""
        least = np.concatenate([vertices - self.lower, self.upper - vertices]).min() - self.robot_radius
        path = shapely.LineString(vertices)
        for obstacle in self.obstacles:
            if covers(obstacle, vertices).any():
                return None
            if "circle" in obstacle:
                gap = path.distance(shapely.Point(obstacle["circle"]["center"])) - obstacle["circle"]["radius"]
            else:
                gap = path.distance(shapely.Polygon(corners(obstacle)))
            least = min(least, gap - self.robot_radius)
        return least if least > 0 else None


def _extreme(values, directions, sign):
    """Per column of `values` [K, M]: the least (sign +1) or greatest (sign -1), its direction, and whether no rival pulls elsewhere."""
    best = np.argmin(sign * values, axis=0)
    columns = np.arange(values.shape[1])
    value, direction = values[best, columns], directions[best, columns]
    rival = (sign * (values - value) < KINK_GAP) & (np.sum(directions * direction, axis=2) < KINK_COSINE)
    return value, direction, ~rival.any(axis=0)


class Objective:
    """U for a space, start and goal (task units); trajectories are waypoints [N, 2] in normalised coordinates."""

    def __init__(self, space, start, goal, substeps, epsilon, weight):
        self.space, self.substeps, self.epsilon, self.weight = space, substeps, epsilon, weight
        self.start, self.goal = space.to_normalised(start), space.to_normalised(goal)

    def vertices(self, waypoints):
        """Start, waypoints, goal: [N+2, 2]."""
        return np.vstack([self.start, waypoints, self.goal])

    def _distances(self, waypoints):
        points = np.vstack([waypoints, substep_points(self.vertices(waypoints), self.substeps).reshape(-1, 2)])
        distance, gradient, smooth = self.space.distance(self.space.to_task(points))
        return distance / self.space.scale, gradient, smooth  # the scale cancels in dD/dx

    def parts(self, waypoints):
        """(F_obs, F_len)."""
        distance, _, _ = self._distances(waypoints)
        eps, count = self.epsilon, len(waypoints)
        cost = np.where(distance <= 0, eps / 2 - distance, np.clip(eps - distance, 0, None) ** 2 / (2 * eps))
        length = np.sum(np.diff(self.vertices(waypoints), axis=0) ** 2)
        return cost[:count].mean() + cost[count:].mean(), length

    def value(self, waypoints):
        """U."""
        obstacle, length = self.parts(waypoints)
        return obstacle + self.weight * length

    def gradient(self, waypoints):
        """dU/dxi [N, 2], and whether every point that feels an obstacle is off D's kinks."""
        distance, direction, smooth = self._distances(waypoints)
        count, steps = len(waypoints), self.substeps
        slope = np.clip((distance - self.epsilon) / self.epsilon, -1.0, 0.0)  # dc/dD
        pull = slope[:, None] * direction
        fraction = (np.arange(1, steps + 1) / (steps + 1))[None, :, None]
        between = pull[count:].reshape(count + 1, steps, 2) / ((count + 1) * steps)
        vertices = self.vertices(waypoints)
        stretch = 2 * (2 * vertices[1:-1] - vertices[:-2] - vertices[2:])
        shared = np.sum(fraction * between, axis=1)[:-1] + np.sum((1 - fraction) * between, axis=1)[1:]
        felt = distance < self.epsilon + KINK_GAP
        return pull[:count] / count + shared + self.weight * stretch, bool(smooth[felt].all())

    def central_difference(self, waypoints, width=1e-6):
        """dU/dxi by central differences, to check `gradient` with."""
        result = np.zeros_like(waypoints)
        for index in np.ndindex(waypoints.shape):
            shift = np.zeros_like(waypoints)
            shift[index] = width
            result[index] = (self.value(waypoints + shift) - self.value(waypoints - shift)) / (2 * width)
        return result
