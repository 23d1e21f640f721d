"""The paper's objective, task generator and feasibility check, as its authors ran them, in float64 NumPy and SciPy.

Formulas ("Learning to Optimize Motion Planning", section I.A), with D the signed distance in world units:

    c(x)   = eps/2 - D                  where D <= 0
           = (D - eps)^2 / (2 eps)      where 0 < D <= eps
           = 0                          elsewhere
    F_obs  = mean of c over all N + (N+1) S points   (the paper's text averages waypoints and substeps apart)
    F_len  = sum of squared segment lengths
    U      = F_obs + lambda F_len

Units: a pixel coordinate u and a world coordinate x belong together by x = 0.1 (u + 0.5). Tasks are in pixels, trajectories in
world units.

Two quirks of the original are kept. The distance is an image (Euclidean distance transform, wall included as a frame of one
pixel) read bilinearly, so an obstacle's zero level lies half a pixel below the box that the feasibility check uses. The gradient
of the distance is a Sobel filter that is not divided by 8; `sobel_divisor=8` gives the gradient its true size.

Where this departs from the original: gradients stay in float64, the original rounded them to float32.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

FIELD = 64
VOXEL = 0.1
EPSILON = 1.0
LAMBDA = 0.1
WAYPOINTS = 10
SUBSTEPS = 5
CHECK_SUBSTEPS = 10
OBSTACLES = 10


def to_world(pixel):
    """World coordinates of pixel coordinates."""
    return VOXEL * (np.asarray(pixel) + 0.5)


def to_pixel(world):
    """Pixel coordinates of world coordinates."""
    return np.asarray(world) * (1 / VOXEL) - 0.5


@dataclass(frozen=True)
class Task:
    """Rectangles `[lower, lower + size]` (int, [R, 2] each), start and goal (int, [2]), all in pixels."""

    lower: np.ndarray
    size: np.ndarray
    start: np.ndarray
    goal: np.ndarray

    @property
    def upper(self):
        """Upper right corners [R, 2], not cropped to the field."""
        return self.lower + self.size


def draw_task(rng):
    """A task of the paper's easy suite: corners U{0..63}, sizes U{10..19}, start and goal U{1..62} off every closed box."""
    lower = rng.integers(0, FIELD, (OBSTACLES, 2))
    size = rng.integers(10, 20, (OBSTACLES, 2))
    while True:
        start, goal = rng.integers(1, FIELD - 1, (2, 2))
        covered = [np.any(np.all((p >= lower) & (p <= lower + size), axis=1)) for p in (start, goal)]
        if not any(covered):
            return Task(lower, size, start, goal)


def distance_image(task):
    """Signed distance at pixel centres, world units, [64, 64], first axis x; the wall counts as an obstacle."""
    occupied = np.ones((FIELD + 2, FIELD + 2), dtype=bool)
    occupied[1:-1, 1:-1] = False
    for (x0, y0), (x1, y1) in zip(task.lower, task.upper):
        occupied[1 + x0 : 1 + min(x1, FIELD), 1 + y0 : 1 + min(y1, FIELD)] = True
    outside = ndimage.distance_transform_edt(~occupied, sampling=VOXEL)
    inside = ndimage.distance_transform_edt(occupied, sampling=VOXEL)
    return (outside - inside)[1:-1, 1:-1]


def sobel_image(distance):
    """Sobel response over the voxel, [2, 64, 64]: eight times the slope of `distance`, with zeros assumed past the edge."""
    return np.stack([ndimage.sobel(distance, axis=axis, mode="constant", cval=0.0) / VOXEL for axis in (0, 1)])


def read_bilinear(image, world_points):
    """`image` [64, 64] at world points [M, 2], the edge pixel's value continued outwards."""
    return ndimage.map_coordinates(image, to_pixel(world_points).T, order=1, mode="nearest")


def straight_line(start, goal, waypoints=WAYPOINTS):
    """Waypoints [N, 2] at fractions i / (N+1) of the way."""
    fraction = np.arange(1, waypoints + 1)[:, None] / (waypoints + 1)
    return start + fraction * (goal - start)


def substep_points(vertices, substeps):
    """Points [(N+1), S, 2] at fractions j / (S+1), j = 1..S, of each segment of `vertices` [N+2, 2]."""
    fraction = (np.arange(1, substeps + 1) / (substeps + 1))[None, :, None]
    return (1 - fraction) * vertices[:-1, None] + fraction * vertices[1:, None]


class Objective:
    """U and its parts for one task; trajectories are waypoints [N, 2] in world units."""

    def __init__(self, task):
        self.task = task
        self.start, self.goal = to_world(task.start), to_world(task.goal)
        self.distance = distance_image(task)
        self.sobel = sobel_image(self.distance)

    def signed_distance(self, points):
        """D at world points [M, 2], world units."""
        return read_bilinear(self.distance, points)

    def distance_gradient(self, points, sobel_divisor=1.0):
        """The Sobel image read at world points, [M, 2]."""
        return np.stack([read_bilinear(image, points) for image in self.sobel], axis=1) / sobel_divisor

    def vertices(self, waypoints):
        """Start, waypoints, goal: [N+2, 2]."""
        return np.vstack([self.start, waypoints, self.goal])

    def cost_points(self, waypoints):
        """The N waypoints, then the (N+1) S substeps, [M, 2]."""
        return np.vstack([waypoints, substep_points(self.vertices(waypoints), SUBSTEPS).reshape(-1, 2)])

    def obstacle_cost(self, waypoints):
        """F_obs."""
        distance = self.signed_distance(self.cost_points(waypoints))
        near = np.where(distance <= EPSILON, (distance - EPSILON) ** 2 / (2 * EPSILON), 0.0)
        return np.mean(np.where(distance <= 0, EPSILON / 2 - distance, near))

    def length_cost(self, waypoints):
        """F_len."""
        return np.sum(np.diff(self.vertices(waypoints), axis=0) ** 2)

    def value(self, waypoints):
        """U."""
        return self.obstacle_cost(waypoints) + LAMBDA * self.length_cost(waypoints)

    def gradient(self, waypoints, sobel_divisor=1.0):
        """dU/dxi [N, 2]. At D = 0 and D = eps both sides of c have the same slope, so no choice is made there."""
        count = len(waypoints)
        points = self.cost_points(waypoints)
        slope = np.clip((self.signed_distance(points) - EPSILON) / EPSILON, -1.0, 0.0)  # dc/dD
        pull = slope[:, None] * self.distance_gradient(points, sobel_divisor) / len(points)
        # A substep at fraction f of a segment moves by 1 - f with the segment's first vertex and by f with its second.
        fraction = (np.arange(1, SUBSTEPS + 1) / (SUBSTEPS + 1))[None, :, None]
        between = pull[count:].reshape(count + 1, SUBSTEPS, 2)
        to_second = np.sum(fraction * between, axis=1)[:-1]
        to_first = np.sum((1 - fraction) * between, axis=1)[1:]
        vertices = self.vertices(waypoints)
        stretch = 2 * (2 * vertices[1:-1] - vertices[:-2] - vertices[2:])
        return pull[:count] + to_second + to_first + LAMBDA * stretch

    def feasible(self, waypoints, slack=0.0):
        """Whether every vertex and 10 substeps per segment are outside each open box and strictly inside 0 < u < 64.

        `slack` (pixels) shrinks the boxes and widens the field; a verdict that is the same for a tiny positive and negative
        slack does not hang on the last bit of a coordinate.
        """
        vertices = self.vertices(waypoints)
        points = to_pixel(np.vstack([vertices, substep_points(vertices, CHECK_SUBSTEPS).reshape(-1, 2)]))
        lower, upper = self.task.lower + slack, self.task.upper - slack
        hit = np.all((points[:, None] > lower) & (points[:, None] < upper), axis=2).any()
        within = np.all((points > -slack) & (points < FIELD + slack))
        return bool(within and not hit)

    def descent(self, waypoints, steps, step=0.1, sobel_divisor=1.0):
        """Yields the waypoints after 0, 1, ..., `steps` steps of plain gradient descent."""
        yield waypoints
        for _ in range(steps):
            waypoints = waypoints - step * self.gradient(waypoints, sobel_divisor)
            yield waypoints
