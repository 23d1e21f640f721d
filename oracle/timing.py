"""golden/timing.json: durations of time-optimal trajectories, by toppra on a fine grid.

The paths are those of the crate's `timing` room: straight lines whose corners are cut by parabolas r before and after them.
toppra holds the limits at grid points and, by its interpolation scheme, at both ends of each interval. Second computation: a
straight line's duration in closed form.
"""

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint
from toppra.interpolator import AbstractGeometricPath

import golden

GRID = 2000


class Blended(AbstractGeometricPath):
    """A polyline with parabolic corners, by arc length of its control polygon."""

    def __init__(self, waypoints, reach):
        waypoints = np.asarray(waypoints, dtype=float)
        sides = np.diff(waypoints, axis=0)
        lengths = np.linalg.norm(sides, axis=1)
        directions = sides / lengths[:, None]
        cuts = np.concatenate([[0.0], reach, [0.0]])
        self.pieces, start = [], 0.0
        for i, (u, length) in enumerate(zip(directions, lengths)):
            straight = length - cuts[i] - cuts[i + 1]
            self.pieces.append((start, waypoints[i] + cuts[i] * u, u, np.zeros_like(u)))
            start += straight
            if cuts[i + 1] > 0:
                v, r = directions[i + 1], cuts[i + 1]
                self.pieces.append((start, waypoints[i + 1] - r * u, u, (v - u) / (2 * r)))
                start += 2 * r
        self.end = start
        self.starts = np.array([piece[0] for piece in self.pieces])

    def __call__(self, path_positions, order=0):
        s = np.atleast_1d(path_positions)
        rows = []
        for at in s:
            piece = max(0, np.searchsorted(self.starts, at, side="right") - 1)
            start, q, u, bend = self.pieces[piece]
            ds = at - start
            rows.append([q + ds * u + 0.5 * ds * ds * bend, u + ds * bend, bend][order])
        return np.array(rows) if np.ndim(path_positions) else rows[0]

    @property
    def dof(self):
        return len(self.pieces[0][1])

    @property
    def path_interval(self):
        return np.array([0.0, self.end])

    @property
    def waypoints(self):
        return None


def duration(path, velocity, acceleration):
    limits = [
        toppra.constraint.JointVelocityConstraint(np.column_stack([-velocity, velocity])),
        toppra.constraint.JointAccelerationConstraint(
            np.column_stack([-acceleration, acceleration]),
            discretization_scheme=toppra.constraint.DiscretizationType.Interpolation,
        ),
    ]
    # The pieces' ends lie on the grid, so that no interval spans a jump of the curvature.
    grid = np.unique(np.concatenate([np.linspace(0, path.end, GRID), path.starts]))
    grid = grid[np.concatenate([[True], np.diff(grid) > 1e-9])]
    grid[-1] = path.end
    instance = toppra.algorithm.TOPPRA(limits, path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    _, sd, _ = instance.compute_parameterization(0, 0)
    if sd is None or not np.all(np.isfinite(sd)):
        raise ValueError("toppra found no timing")
    return float(np.sum(2 * np.diff(grid) / (sd[1:] + sd[:-1])))


def trapezoid(way, velocity, acceleration):
    u = np.abs(way) / np.linalg.norm(way)
    v, a, d = np.min(velocity / np.maximum(u, 1e-12)), np.min(acceleration / np.maximum(u, 1e-12)), np.linalg.norm(way)
    return d / v + v / a if v * v / a < d else 2 * np.sqrt(d / a)


def main():
    rng = np.random.default_rng(5)
    cases = []
    for dof, n in [(2, 2), (7, 2), (2, 3), (3, 5), (6, 8), (7, 4), (7, 12)]:
        waypoints = golden.decimals(rng.uniform(-2, 2, size=(n, dof)), 3)
        sides = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
        share = rng.uniform(0.05, 0.45, size=n - 2)
        reach = golden.decimals(share * np.minimum(sides[:-1], sides[1:]), 3)
        velocity = golden.decimals(rng.uniform(1, 3, size=dof), 2)
        acceleration = golden.decimals(rng.uniform(2, 15, size=dof), 2)
        found = duration(Blended(waypoints, reach), velocity, acceleration)
        if n == 2:
            exact = trapezoid(waypoints[1] - waypoints[0], velocity, acceleration)
            if abs(found / exact - 1) > 1e-3:
                raise ValueError(f"{found} for {exact}")
        print(dof, n, found)
        cases.append({"waypoints": waypoints, "reach": reach, "velocity": velocity, "acceleration": acceleration,
                      "duration": found})
    golden.write("timing.json", {"tolerance": 0.005, "paths": cases})


if __name__ == "__main__":
    main()
