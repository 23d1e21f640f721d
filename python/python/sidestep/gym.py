"""Gymnasium environments: a trajectory is improved step by step until it is feasible.

    envs = gymnasium.make_vec("sidestep.gym:sidestep/Optimize-v0", num_envs=256, suite="easy")   # stepped in Rust
    env = gymnasium.make("sidestep.gym:sidestep/Optimize-v0", suite="hard")

Keywords: `suite`, `tasks` (how many of it, or a list of tasks of your own), `task_seed`, `waypoints`, `profile`, `parts` (of
the observation), `mu`, `bonus`, and `reward`, a function of (U, terminated) as arrays that gives the rewards.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from . import _sidestep
from ._sidestep import Batch, Task

ID = "sidestep/Optimize-v0"
Reward = Callable[[NDArray[np.float32], NDArray[np.bool_]], NDArray[np.float32]]
_RESETS = {
    AutoresetMode.NEXT_STEP: "next-step",
    AutoresetMode.SAME_STEP: "same-step",
    AutoresetMode.DISABLED: "never",
}


def _tasks(suite: str, tasks: int | Sequence[Task], task_seed: int) -> list[Task]:
    if isinstance(tasks, int):
        return _sidestep.suite(suite, tasks, seed=task_seed)
    return list(tasks)


def _spaces(batch: Batch) -> tuple[gym.spaces.Box, gym.spaces.Box]:
    seen = gym.spaces.Box(-np.inf, np.inf, (batch.observation_size,), np.float32)
    # Flat: some clients take no other.
    return seen, gym.spaces.Box(-1.0, 1.0, (batch.action_size,), np.float32)


class OptimizeVectorEnv(VectorEnv):
    """Trajectories of many tasks, stepped in Rust on all cores."""

    def __init__(
        self,
        num_envs: int = 1,
        *,
        suite: str = "easy",
        tasks: int | Sequence[Task] = 100,
        task_seed: int = 0,
        max_episode_steps: int | None = 200,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        reward: Reward | None = None,
        **settings: Any,
    ):
        mode = AutoresetMode(autoreset_mode)
        # On the instance: the class's dictionary would be shared.
        self.metadata = {"render_modes": [], "autoreset_mode": mode}
        self.render_mode = render_mode
        self.num_envs = num_envs
        self._reward = reward
        self._closed = False
        self._ready = False
        chosen = _tasks(suite, tasks, task_seed)
        self._batch = Batch(chosen, num_envs, limit=max_episode_steps, reset=_RESETS[mode], **settings)
        self.single_observation_space, self.single_action_space = _spaces(self._batch)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None):
        self._check_open()
        super().reset(seed=seed)
        self._ready = True
        mask = (options or {}).get("reset_mask")
        return self._batch.reset(None if mask is None else np.asarray(mask, bool).tolist()), {}

    def step(self, actions: NDArray[np.float32]):
        self._check_open()
        if not self._ready:
            raise RuntimeError("reset() has to be called before step()")
        actions = np.ascontiguousarray(actions, np.float32).reshape(self.num_envs, -1)
        seen, rewards, terminated, truncated, cost, which, last = self._batch.step(actions)
        if self._reward is not None:
            rewards = np.asarray(self._reward(cost, terminated), np.float32)
            if rewards.shape != (self.num_envs,):
                raise ValueError(f"reward: an array of shape {rewards.shape}; expected ({self.num_envs},)")
        infos: dict[str, Any] = {}
        if len(which):
            final = np.full(self.num_envs, None, object)
            mask = np.zeros(self.num_envs, bool)
            for index, row in zip(which, last):
                final[index], mask[index] = row, True
            infos = {"final_obs": final, "_final_obs": mask, "final_info": {}, "_final_info": mask.copy()}
        return seen, rewards, terminated, truncated, infos

    def close_extras(self, **kwargs: Any) -> None:
        self._closed = True

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError("the environments are closed")


class OptimizeEnv(gym.Env):
    """One such trajectory. `render()` is a picture as an array, with `render_mode="rgb_array"`."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        *,
        suite: str = "easy",
        tasks: int | Sequence[Task] = 100,
        task_seed: int = 0,
        render_mode: str | None = None,
        reward: Reward | None = None,
        **settings: Any,
    ):
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode: {render_mode!r} is not allowed; expected None or 'rgb_array'")
        self.render_mode = render_mode
        self._reward = reward
        self._ready = False
        self._tasks = _tasks(suite, tasks, task_seed)
        self._first = self._tasks[:1]
        # The time limit is `gymnasium.make`'s wrapper. One environment walks the tasks in turn.
        self._batch = Batch(self._tasks, 1, reset="never", **settings)
        self._episode = -1
        self.observation_space, self.action_space = _spaces(self._batch)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None):
        super().reset(seed=seed)
        again = seed is not None or not self._ready
        self._ready = True
        self._episode = 0 if again else self._episode + 1
        return self._batch.reset(None if again else [True])[0], {}

    def step(self, action: NDArray[np.float32]):
        if not self._ready:
            raise RuntimeError("reset() has to be called before step()")
        action = np.ascontiguousarray(action, np.float32).reshape(1, -1)
        seen, rewards, terminated, truncated, cost, _, _ = self._batch.step(action)
        if self._reward is not None:
            rewards = self._reward(cost, terminated)
        return seen[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), {"cost": float(cost[0])}

    def render(self) -> NDArray[np.uint8] | None:
        if self.render_mode is None:
            return None
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from matplotlib.patches import Circle, Polygon, Rectangle

        task = self._tasks[self._episode % len(self._tasks)]
        figure = Figure(figsize=(4, 4), dpi=80)
        canvas = FigureCanvasAgg(figure)
        ax = figure.add_axes((0, 0, 1, 1))
        for kind, points in task.obstacles:
            if kind == "rect":
                (x, y), (right, top) = points
                ax.add_patch(Rectangle((x, y), right - x, top - y, fc="#9fabb7"))
            elif kind == "circle":
                ax.add_patch(Circle(points[0], points[1][0], fc="#9fabb7"))
            else:
                ax.add_patch(Polygon(points, fc="#9fabb7"))
        (left, bottom), (right, top) = task.bounds or ((0, 0), (1, 1))
        # Normalised units: the field's larger side is 6.4.
        unit = max(right - left, top - bottom) / 6.4
        inner = np.array([left, bottom]) + unit * self._batch.waypoints()[0].astype(float)
        path = np.vstack([task.start, inner, task.goal])
        ax.plot(*path.T, marker=".", color="#0072b2")
        ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()


# Importing this module registers; `gymnasium.make("sidestep.gym:sidestep/Optimize-v0")` imports it.
if ID not in gym.registry:
    gym.register(
        ID,
        entry_point="sidestep.gym:OptimizeEnv",
        vector_entry_point="sidestep.gym:OptimizeVectorEnv",
        max_episode_steps=200,
    )
