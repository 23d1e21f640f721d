"""Stable-Baselines3 on the environments that are stepped in Rust, and what it trained as a policy.

    envs = sidestep.sb3.OptimizeVecEnv(128, suite="easy", max_episode_steps=40)
    model = PPO("MlpPolicy", envs, policy_kwargs={"net_arch": [64, 64]}).learn(100_000)
    sidestep.sb3.policy(model).save("mine.safetensors")
    sidestep.plan(task, "learned:mine.safetensors")
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv
from torch import nn

from . import _sidestep
from . import torch as _torch
from ._sidestep import Batch, Policy, Task


class OptimizeVecEnv(VecEnv):
    """Trajectories of many tasks, an episode reset in the step that ends it, as Stable-Baselines3 wants; keywords as of
    `sidestep.gym`. Infos carry the episode's return and length, so no monitor is needed."""

    def __init__(
        self,
        num_envs: int,
        *,
        suite: str = "easy",
        tasks: int | Sequence[Task] = 100,
        task_seed: int = 0,
        waypoints: int = 10,
        profile: str = "paper",
        parts: Sequence[str] = ("gradient",),
        max_episode_steps: int | None = 200,
        **settings: Any,
    ):
        chosen = _sidestep.suite(suite, tasks, seed=task_seed) if isinstance(tasks, int) else list(tasks)
        shape = {"waypoints": waypoints, "profile": profile, "parts": list(parts)}
        self._batch = Batch(chosen, num_envs, limit=max_episode_steps, reset="same-step", **shape, **settings)
        self.card = {"observation": list(parts), "waypoints": waypoints, "profile": profile, "dof": chosen[0].dof}
        self.render_mode = None
        seen = Box(-np.inf, np.inf, (self._batch.observation_size,), np.float32)
        super().__init__(num_envs, seen, Box(-1.0, 1.0, (self._batch.action_size,), np.float32))
        self._return, self._age = np.zeros(num_envs), np.zeros(num_envs, int)
        self._actions: NDArray[np.float32] | None = None
        self._ready = False

    def reset(self) -> NDArray[np.float32]:
        # Episodes take the tasks in turn; there is nothing that a seed would choose.
        self._reset_seeds()
        self._reset_options()
        self._return[:], self._age[:], self._ready = 0, 0, True
        return self._batch.reset()

    def step_async(self, actions: NDArray[np.float32]) -> None:
        if not self._ready:
            raise RuntimeError("reset() has to be called before step()")
        self._actions = np.ascontiguousarray(actions, np.float32)

    def step_wait(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        if self._actions is None:
            raise RuntimeError("step_async() has to be called before step_wait()")
        actions, self._actions = self._actions, None
        seen, rewards, terminated, truncated, _, which, last = self._batch.step(actions)
        self._return += rewards
        self._age += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for index, final in zip(which, last):
            infos[index] = {
                "terminal_observation": final,
                "TimeLimit.truncated": bool(truncated[index]),
                "episode": {"r": float(self._return[index]), "l": int(self._age[index])},
            }
        self._return[which], self._age[which] = 0, 0
        return seen, rewards, terminated | truncated, infos

    def close(self) -> None:
        self._ready = False

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError("the environments of a batch have no attributes of their own")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        raise NotImplementedError("the environments of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))


def policy(model: BaseAlgorithm, *, licence: str = "MIT OR Apache-2.0") -> Policy:
    """The policy of an on-policy model (PPO, A2C) with `MlpPolicy` and tanh, trained on `OptimizeVecEnv`; it answers the mean
    action."""
    net, envs = model.policy, model.get_env()
    card = envs.get_attr("card")[0] if envs is not None else None
    if card is None:
        raise ValueError("model: its environments are not sidestep.sb3.OptimizeVecEnv")
    extractor = getattr(net, "mlp_extractor", None)
    hidden = getattr(extractor, "policy_net", None)
    if hidden is None or not all(isinstance(layer, (nn.Linear, nn.Tanh)) for layer in hidden):
        raise ValueError("model: its policy is no perceptron with tanh; expected MlpPolicy with activation_fn=Tanh")
    layers = [*(layer for layer in hidden if isinstance(layer, nn.Linear)), net.action_net]
    made = {"by": f"stable-baselines3 {type(model).__name__}", "steps": model.num_timesteps, "seed": model.seed}
    return _torch.perceptron(layers, **card, training=made, licence=licence)
