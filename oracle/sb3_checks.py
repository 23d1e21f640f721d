"""Stable-Baselines3's own advantages and update, which the golden PPO values are held against before they are written.

Stable-Baselines3 computes in float32, so these checks are looser than the golden values; they settle conventions (which mean,
which standard deviation, what the coefficients multiply), not digits.
"""

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.vec_env import DummyVecEnv


def check_advantages(rewards, values, dones, last_values, discount, expected):
    """Against Stable-Baselines3's buffer, to float32 accuracy."""
    space = gymnasium.spaces.Box(-1, 1, (1,))
    buffer = RolloutBuffer(6, space, space, device="cpu", gae_lambda=0.95, gamma=discount, n_envs=3)
    starts = np.vstack([np.ones(3), dones[:-1]])
    for reward, value, start in zip(rewards, values, starts):
        zero = np.zeros((3, 1))
        buffer.add(zero, zero, reward, start, torch.tensor(value), torch.zeros(3))
    buffer.compute_returns_and_advantage(torch.tensor(last_values), dones[-1])
    np.testing.assert_allclose(buffer.advantages, expected, atol=2e-5)
    np.testing.assert_allclose(buffer.returns, expected + values, atol=2e-5)


class Placeholder(gymnasium.Env):
    """Spaces only: Stable-Baselines3 needs an environment to build its policy."""

    observation_space = gymnasium.spaces.Box(-10, 10, (4,))
    action_space = gymnasium.spaces.Box(-10, 10, (4,))

    def reset(self, *, seed=None, options=None):
        return np.zeros(4, dtype=np.float32), {}

    def step(self, action):
        return np.zeros(4, dtype=np.float32), 0.0, False, False, {}


PLACES = {
    "policy": ("mlp_extractor.policy_net.0", "mlp_extractor.policy_net.2", "action_net"),
    "value": ("mlp_extractor.value_net.0", "mlp_extractor.value_net.2", "value_net"),
}


def named(parameters):
    """A tree of parameters under Stable-Baselines3's names."""
    table = {"log_std": parameters["log_std"]}
    for net, places in PLACES.items():
        for place, layer in zip(places, parameters[net]):
            table |= {f"{place}.{kind}": layer[kind] for kind in ("weight", "bias")}
    return {name: torch.as_tensor(value) for name, value in table.items()}


def check_update(start, batch, entropy_coefficient, learning_rate, step):
    """One update by Stable-Baselines3's own `train` on the same minibatch: same clipped gradient, same parameters afterwards."""
    count, hidden = len(batch["returns"]), len(start["policy"][0]["bias"])
    model = PPO(
        "MlpPolicy",
        DummyVecEnv([Placeholder]),
        n_steps=count,
        batch_size=count,
        n_epochs=1,
        learning_rate=learning_rate,
        ent_coef=entropy_coefficient,
        policy_kwargs={"net_arch": {"pi": [hidden, hidden], "vf": [hidden, hidden]}},
        device="cpu",
    )
    model._setup_learn(count, None)
    model.policy.load_state_dict({name: value.float() for name, value in named(start).items()})
    buffer = model.rollout_buffer
    for k in range(count):
        one = {key: item[k : k + 1] for key, item in batch.items()}
        row = (one["observations"].numpy(), one["actions"].numpy(), np.zeros(1), np.zeros(1))
        buffer.add(*row, torch.zeros(1), one["old_log_probs"])
    buffer.advantages[:, 0], buffer.returns[:, 0] = batch["advantages"].numpy(), batch["returns"].numpy()
    model.train()
    gradient, after = named(step["clipped_gradient"]), named(step["parameters_after"])
    for name, value in model.policy.named_parameters():
        np.testing.assert_allclose(value.grad.numpy(), gradient[name].numpy(), atol=2e-6, err_msg=name)
        np.testing.assert_allclose(value.detach().numpy(), after[name].numpy(), atol=3e-6, err_msg=name)
