"""Policies as PyTorch modules and back, and what PyTorch trains as policies of ours."""

import os
import subprocess
import sys

import numpy as np
import pytest
import sidestep
from test_policies import ALL, arm, arm_trajectories, get, trajectories

if not os.environ.get("SIDESTEP_CHECK_CLIENTS"):
    pytest.skip("SIDESTEP_CHECK_CLIENTS is not set", allow_module_level=True)
torch = pytest.importorskip("torch")

from sidestep import torch as st  # noqa: E402


@pytest.mark.parametrize("name", ALL)
def test_a_module_answers_as_planning_does(name):
    policy = get(name)
    module = st.module(policy)
    assert {name: tuple(p.shape) for name, p in module.named_parameters()} == {
        name: array.shape for name, array in policy.tensors().items()
    }
    sizes = [1, 3, 10, 57, 100] if policy.card["architecture"] == "waypoint" else [policy.card["waypoints"]]
    for seed, waypoints in enumerate(sizes):
        tasks, x = trajectories(policy, 50, waypoints, seed)
        inputs, update = policy.look(tasks, x)
        tensors = {name: torch.from_numpy(array) for name, array in inputs.items()}
        with torch.no_grad():
            found = module(**tensors).numpy()
        np.testing.assert_allclose(found, update, atol=1e-5, rtol=0)
    # Every parameter matters, and can be trained.
    module(**tensors, scaled=False).square().sum().backward()
    assert all(p.grad is not None and bool(p.grad.abs().sum() > 0) for p in module.parameters())


@pytest.mark.parametrize("name", ALL)
def test_a_module_comes_back(name):
    policy = get(name)
    module = st.module(policy)
    assert st.policy(module).to_bytes() == policy.to_bytes()
    with torch.no_grad():
        for parameter in module.parameters():
            parameter.mul_(0.5)
    halved = st.policy(module, training={"by": "a test"}, licence="CC0-1.0")
    assert halved.card["training"] == {"by": "a test"} and halved.card["licence"] == "CC0-1.0"
    assert all((array == 0.5 * policy.tensors()[name]).all() for name, array in halved.tensors().items())


def test_a_module_of_joints_answers_as_planning_does():
    tasks, policy = arm()
    module = st.module(policy)
    for waypoints in (1, 10, 40):
        inputs, update = policy.look(tasks, arm_trajectories(tasks, waypoints, 1))
        with torch.no_grad():
            found = module(**{name: torch.from_numpy(array) for name, array in inputs.items()}).numpy()
        np.testing.assert_allclose(found, update, atol=1e-5, rtol=0)
    assert st.policy(module).to_bytes() == policy.to_bytes()


def test_a_map_cannot_be_left_out():
    module = st.module("sidestep-1")
    with pytest.raises(ValueError, match="map, places"):
        module(torch.zeros(1, 10, module.card["sizes"][0]))


def test_stable_baselines_trains_a_policy(tmp_path):
    stable = pytest.importorskip("stable_baselines3")
    from sidestep import sb3

    envs = sb3.OptimizeVecEnv(64, suite="easy", tasks=64, max_episode_steps=40, task_seed=1000)
    ended = []

    def watch(local, _):
        for info, done in zip(local["infos"], local["dones"]):
            assert done == ("terminal_observation" in info)
            if done:
                ended.append(info["episode"]["l"])
        return True

    settings = {"net_arch": [64, 64], "log_std_init": -2.0}
    model = stable.PPO("MlpPolicy", envs, n_steps=40, batch_size=640, n_epochs=4, gamma=0.85, policy_kwargs=settings, seed=0)
    model.learn(20_480, callback=watch)
    assert len(ended) > 100 and max(ended) <= 40 and len(model.ep_info_buffer) > 0
    policy = sb3.policy(model)
    policy.save(tmp_path / "sb3.safetensors")
    # The mean action of one is that of the other.
    tasks, x = trajectories(policy, 20, 10, 3)
    inputs, update = policy.look(tasks, x)
    mean, _ = model.predict(inputs["rows"], deterministic=True)
    np.testing.assert_allclose(mean.reshape(20, 10, 2), update.clip(-1, 1), atol=1e-5)
    plan = sidestep.plan(tasks[0], f"learned:{tmp_path}/sb3.safetensors")
    assert plan.status in ("solved", "unsolved") and plan.iterations >= 1
    words = ["bench", "--suite", "easy", "--count", "10", "--seeds", "7", "--planner", f"learned:{tmp_path}/sb3.safetensors", "--timed", "2"]
    answer = subprocess.run([sys.executable, "-m", "sidestep", *words, "--out", tmp_path / "r.json"], capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    assert (tmp_path / "r.json").is_file()
    with pytest.raises(ValueError, match="tanh"):
        relu = stable.PPO("MlpPolicy", envs, policy_kwargs={"activation_fn": torch.nn.ReLU})
        sb3.policy(relu)
    with pytest.raises(RuntimeError, match="reset"):
        sb3.OptimizeVecEnv(2).step(np.zeros((2, 20), np.float32))
