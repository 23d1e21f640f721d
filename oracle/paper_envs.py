"""The paper's reinforcement-learning environment twice: as the original is built, and with all environments in one array.

Both: observation dU/dxi (2 N numbers, the paper's gradient), action Delta xi clipped to +-1 world unit, waypoints clipped to
[0, 6.4], reward -U, or -0.1 U once feasible, which ends the episode; no time limit; the start is always the straight line
(section I.B).

`PaperEnv` is one Gymnasium environment per task that reads images through SciPy and looks at collision points one by one, which
is what the original does. `BatchedPaperEnv` does the same arithmetic for all tasks at once in float32 NumPy: what a careful user
of Stable-Baselines3 would write. `assert_same` holds the two against each other.
"""

import gymnasium
import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from paper_profile import (
    CHECK_SUBSTEPS,
    EPSILON,
    FIELD,
    LAMBDA,
    SUBSTEPS,
    VOXEL,
    WAYPOINTS,
    Objective,
    draw_task,
    straight_line,
    substep_points,
    to_pixel,
)

WORLD = FIELD * VOXEL
FEASIBLE_FACTOR = 0.1  # mu
SIZE = 2 * WAYPOINTS


class PaperEnv(gymnasium.Env):
    """One task; waypoints are world units."""

    def __init__(self, task):
        self.objective = Objective(task)
        self.action_space = gymnasium.spaces.Box(-1, 1, (SIZE,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (SIZE,), np.float32)

    def _observation(self):
        return self.objective.gradient(self.waypoints).ravel().astype(np.float32)

    def _feasible(self):
        task, vertices = self.objective.task, self.objective.vertices(self.waypoints)
        points = to_pixel(np.vstack([vertices, substep_points(vertices, CHECK_SUBSTEPS).reshape(-1, 2)]))
        hits = [np.any(np.all((point > task.lower) & (point < task.upper), axis=1)) for point in points]
        return bool(not any(hits) and np.all((points > 0) & (points < FIELD)))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.waypoints = straight_line(self.objective.start, self.objective.goal)
        return self._observation(), {}

    def step(self, action):
        self.waypoints = np.clip(self.waypoints + action.reshape(WAYPOINTS, 2), 0, WORLD)
        feasible = self._feasible()
        reward = -self.objective.value(self.waypoints) * (FEASIBLE_FACTOR if feasible else 1.0)
        return self._observation(), float(reward), feasible, False, {}


class BatchedPaperEnv(VecEnv):
    """All tasks in arrays of shape [E, points, 2], pixels for images and boxes, world units for waypoints, all float32."""

    def __init__(self, tasks):
        count = len(tasks)
        objectives = [Objective(task) for task in tasks]
        action = gymnasium.spaces.Box(-1, 1, (SIZE,), np.float32)
        super().__init__(count, gymnasium.spaces.Box(-np.inf, np.inf, (SIZE,), np.float32), action)
        # Distance and both slopes side by side per pixel, so that one read serves all three: [E 64 64, 3].
        images = np.stack([np.stack([o.distance, *o.sobel], axis=-1) for o in objectives])
        self.images = np.ascontiguousarray(images.reshape(-1, 3), dtype=np.float32)
        self.first_pixel = (np.arange(count) * FIELD * FIELD)[:, None]
        self.lower = np.stack([t.lower for t in tasks]).astype(np.float32)  # [E, R, 2]
        self.upper = np.stack([t.upper for t in tasks]).astype(np.float32)
        self.start = np.stack([o.start for o in objectives]).astype(np.float32)[:, None]
        self.goal = np.stack([o.goal for o in objectives]).astype(np.float32)[:, None]
        self.line = np.stack([straight_line(o.start, o.goal) for o in objectives]).astype(np.float32)
        # Substeps and check points as products with the vertices: [points, N+2].
        self.cost_weights = interpolation(SUBSTEPS)
        self.check_weights = interpolation(CHECK_SUBSTEPS)
        self.waypoints = self.line.copy()
        self.line_gradient = self._evaluate()[1]

    def _vertices(self):
        return np.concatenate([self.start, self.waypoints, self.goal], axis=1)

    def _read(self, pixels):
        """Distance and slopes [E, M, 3] at pixel coordinates [E, M, 2]."""
        pixels = np.clip(pixels, 0, FIELD - 1)
        corner = np.minimum(pixels.astype(np.int32), FIELD - 2)
        fx, fy = np.moveaxis((pixels - corner)[..., None], 2, 0)
        at = self.first_pixel + corner[..., 0] * FIELD + corner[..., 1]
        low = self.images[at] * (1 - fy) + self.images[at + 1] * fy
        high = self.images[at + FIELD] * (1 - fy) + self.images[at + FIELD + 1] * fy
        return low * (1 - fx) + high * fx

    def _evaluate(self):
        """U [E] and its gradient [E, 2 N]."""
        vertices = self._vertices()
        points = np.concatenate([self.waypoints, self.cost_weights @ vertices], axis=1)
        read = self._read(points * np.float32(1 / VOXEL) - np.float32(0.5))
        distance = read[..., 0]
        near = np.clip(EPSILON - distance, 0, EPSILON)
        # Inside an obstacle `near` stays at EPSILON, and the cost goes on with slope 1.
        cost = near**2 / (2 * EPSILON) - np.minimum(distance, 0)
        segments = np.diff(vertices, axis=1)
        value = cost.mean(axis=1) + LAMBDA * np.sum(segments**2, axis=(1, 2))
        pull = -near[..., None] / (EPSILON * points.shape[1]) * read[..., 1:]
        gradient = pull[:, :WAYPOINTS] + self.cost_weights[:, 1:-1].T @ pull[:, WAYPOINTS:]
        gradient += 2 * LAMBDA * (segments[:, :-1] - segments[:, 1:])
        return value, gradient.reshape(self.num_envs, SIZE)

    def _feasible(self):
        vertices = self._vertices()
        points = np.concatenate([vertices, self.check_weights @ vertices], axis=1)
        points = (points * np.float32(1 / VOXEL) - np.float32(0.5))[:, None]  # [E, 1, M, 2]
        lower, upper = self.lower[:, :, None], self.upper[:, :, None]  # [E, R, 1, 2]
        x, y = points[..., 0], points[..., 1]
        hit = (x > lower[..., 0]) & (x < upper[..., 0]) & (y > lower[..., 1]) & (y < upper[..., 1])
        within = (points > 0) & (points < FIELD)
        return within.all(axis=(1, 2, 3)) & ~hit.any(axis=(1, 2))

    def reset(self):
        self.waypoints = self.line.copy()
        return self.line_gradient.copy()

    def step_async(self, actions):
        self.actions = actions

    def step_wait(self):
        moved = self.waypoints + self.actions.reshape(self.num_envs, WAYPOINTS, 2)
        self.waypoints = np.clip(moved, 0, np.float32(WORLD))
        done = self._feasible()
        value, observation = self._evaluate()
        reward = -value * np.where(done, FEASIBLE_FACTOR, 1.0)
        infos = [{} for _ in range(self.num_envs)]
        for env in np.flatnonzero(done):
            infos[env] = {"terminal_observation": observation[env].copy(), "TimeLimit.truncated": False}
        self.waypoints[done] = self.line[done]
        observation[done] = self.line_gradient[done]
        return observation, reward.astype(np.float32), done, infos

    def close(self):
        pass

    def get_attr(self, attr_name, indices=None):
        return [getattr(self, attr_name, None)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name, value, indices=None):
        setattr(self, attr_name, value)

    def env_method(self, method_name, *args, indices=None, **kwargs):
        raise NotImplementedError("one array holds all environments")

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * len(list(self._get_indices(indices)))


def interpolation(substeps):
    """Weights [(N+1) S, N+2] that turn vertices into the substeps of all segments."""
    return substep_points(np.eye(WAYPOINTS + 2), substeps).reshape(-1, WAYPOINTS + 2).astype(np.float32)


def draw_tasks(count, seed):
    """`count` easy tasks."""
    rng = np.random.default_rng(seed)
    return [draw_task(rng) for _ in range(count)]


def assert_same(one, other, steps, seed=0, tolerance=2e-4):
    """Two vectorised environments answer the same actions alike, to float32 accuracy."""
    rng = np.random.default_rng(seed)
    np.testing.assert_allclose(one.reset(), other.reset(), atol=tolerance)
    for _ in range(steps):
        actions = rng.normal(0, 0.05, (one.num_envs, SIZE)).astype(np.float32)
        (seen, paid, done, _), (seen2, paid2, done2, _) = one.step(actions), other.step(actions)
        if (done != done2).any():
            raise AssertionError(f"feasibility differs in environments {np.flatnonzero(done != done2).tolist()}")
        np.testing.assert_allclose(seen, seen2, atol=tolerance)
        np.testing.assert_allclose(paid, paid2, atol=tolerance)
