"""Policies taken apart, put together, and run elsewhere."""

import json
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
import sidestep
from sidestep import Policy

POLICIES = Path(__file__).parents[2] / "policies"
FILES = ["gradient-4m", "paper-mlp-80k", "picture"]


def load(name):
    return Policy.load(POLICIES / f"{name}.safetensors" if name in FILES else name)


def made(architecture, observation, sizes, shapes, **card):
    """A policy of random numbers, for architectures of which no file is kept."""
    rng = np.random.default_rng(5)
    first = load("paper-mlp-80k").card
    card = first | {"architecture": architecture, "observation": observation, "sizes": sizes} | card
    scale = lambda shape: 0.7 / np.sqrt(np.prod(shape[1:]))  # noqa: E731
    tensors = {}
    for name, shape in shapes.items():
        tensors[f"{name}.weight"] = rng.normal(0, scale(shape), shape).astype(np.float32)
        tensors[f"{name}.bias"] = rng.normal(0, 0.1, shape[:1]).astype(np.float32)
    return Policy(card, tensors)


def image(observation, others):
    shapes = {"convolutions.0": (16, 8, 8, 1), "convolutions.1": (32, 4, 4, 16), "layers.0": (48, 2048), "layers.1": (20, 48)}
    if others:
        shapes["skip.0"] = (20, others)
    return made("cnn", observation, [4096 + others, 2048, 48, 20], shapes)


MADE = {
    "image": lambda: image(["image"], 0),
    "image-last": lambda: image(["gradient", "ends", "image"], 24),
    "image-between": lambda: image(["gradient", "waypoint-image", "ends"], 24),
    "image-first": lambda: image(["image", "gradient"], 20),
}
ALL = ["sidestep-1", "sidestep-1-small", *FILES, *MADE]


def get(name):
    return MADE[name]() if name in MADE else load(name)


def arm():
    """A robot with joints, some tasks of it, and a policy of random numbers that sees it."""
    robots = Path(__file__).parents[2] / "crates/sidestep-io/tests/robots"
    joints = [f"panda_joint{i}" for i in range(1, 8)]
    robot = sidestep.Robot.from_urdf(robots / "panda_spherized.urdf", srdf=robots / "panda.srdf", joints=joints)
    post = {"name": "post", "shapes": [{"cylinder": {"radius": 0.05, "length": 1.5}, "position": [0.45, 0.25, 0.75]}]}
    scene, rng = sidestep.Scene([post]), np.random.default_rng(3)
    low, high = robot.limits.T
    draw = lambda: low + (high - low) * rng.uniform(0.2, 0.8, 7)  # noqa: E731
    tasks = [robot.task(scene, draw(), draw()) for _ in range(100)]

    def seeing(balls):
        inputs, width = 12 * 7 + 3 * balls + 17, 32
        shapes = {"layers.0": (width, inputs), "layers.5": (7, width)}
        shapes |= {f"layers.{k}": (width, width * (3 if k % 2 else 1)) for k in range(1, 5)}
        more = {"dof": 7, "profile": "default", "action": {"scale": 0.3, "limit": 0.5, "keep_inside": True}}
        return made("waypoint", [f"joints:{balls}"], [inputs, width, 1, 4], shapes, **more)

    x = sidestep.Objective(tasks[:1], waypoints=2).straight_lines()
    with pytest.raises(ValueError, match="joints:") as told:
        seeing(1).look(tasks[:1], x)
    return tasks, seeing(int(re.search(r"joints:([0-9]+)", str(told.value)).group(1)))


def arm_trajectories(tasks, waypoints, seed):
    x = sidestep.Objective(tasks, waypoints=waypoints).straight_lines()
    rng = np.random.default_rng(seed)
    return x + rng.normal(size=x.shape).astype(np.float32) * rng.uniform(0, 0.3, (len(tasks), 1, 1)).astype(np.float32)


def test_a_policy_is_its_card_and_its_arrays(tmp_path):
    for name in ALL:
        policy = get(name)
        again = Policy(policy.card, policy.tensors())
        assert again.to_bytes() == pickle.loads(pickle.dumps(policy)).to_bytes()
        assert again.card == policy.card
        again.save(tmp_path / "policy.safetensors")
        assert Policy.load(tmp_path / "policy.safetensors").to_bytes() == again.to_bytes()
        assert [path.name for path in tmp_path.iterdir()] == ["policy.safetensors"]


def trajectories(policy, count, waypoints, seed):
    tasks = sidestep.suite("hard", count, seed=seed)
    profile = policy.card["profile"]
    objective = sidestep.Objective(tasks, waypoints=waypoints, profile=profile)
    rng = np.random.default_rng(seed)
    x = objective.straight_lines()
    # From hardly moved to all over the field.
    return tasks, x + rng.normal(size=x.shape).astype(np.float32) * rng.uniform(0, 1, (count, 1, 1)).astype(np.float32)


@pytest.mark.parametrize("name", ALL)
def test_onnx_answers_as_planning_does(name, tmp_path):
    """1,000 inputs of each architecture, of 1 to 100 waypoints where they are free."""
    runtime = pytest.importorskip("onnxruntime")
    pytest.importorskip("onnx")
    from sidestep import onnx

    policy = get(name)
    onnx.export(policy, tmp_path / "policy.onnx")
    session = runtime.InferenceSession(tmp_path / "policy.onnx", providers=["CPUExecutionProvider"])
    free = policy.card["architecture"] == "waypoint"
    sizes = [1, 2, 3, 5, 10, 20, 31, 50, 77, 100] if free else [policy.card["waypoints"]] * 10
    worst, moved = 0.0, 0
    for seed, waypoints in enumerate(sizes):
        tasks, x = trajectories(policy, 100, waypoints, seed)
        inputs, update = policy.look(tasks, x)
        assert {i.name for i in session.get_inputs()} == set(inputs)
        (found,) = session.run(["update"], inputs)
        assert found.shape == update.shape == x.shape
        worst = max(worst, float(np.abs(found - update).max()))
        moved += int((np.abs(update) > 1e-3).any((1, 2)).sum())
    assert worst <= 1e-5, worst
    assert moved > 900
    assert json.loads(session.get_modelmeta().custom_metadata_map["sidestep"]) == policy.card


def test_onnx_answers_as_planning_does_with_joints():
    runtime = pytest.importorskip("onnxruntime")
    pytest.importorskip("onnx")
    from sidestep import onnx

    tasks, policy = arm()
    session = runtime.InferenceSession(onnx.to_model(policy).SerializeToString(), providers=["CPUExecutionProvider"])
    for seed, waypoints in enumerate([1, 2, 3, 5, 8, 10, 15, 30, 60, 100]):
        inputs, update = policy.look(tasks, arm_trajectories(tasks, waypoints, seed))
        assert set(inputs) == {"rows", "base"}
        (found,) = session.run(["update"], inputs)
        np.testing.assert_allclose(found, update, atol=1e-5, rtol=0)
        assert ((np.abs(update) > 1e-3) & (np.abs(update) < 0.5)).any((1, 2)).mean() > 0.9


def test_mistakes_with_policies_are_named(tmp_path):
    policy = load("paper-mlp-80k")
    tensors, card = policy.tensors(), policy.card
    tasks, x = trajectories(policy, 2, 10, 0)
    (tmp_path / "broken.safetensors").write_bytes(policy.to_bytes()[:-4])
    less = {name: array for name, array in tensors.items() if name != "layers.0.bias"}
    nan = tensors | {"layers.0.bias": np.full(tensors["layers.0.bias"].shape, np.nan, np.float32)}
    for error, part, call in (
        (ValueError, "nothing", lambda: Policy.load("nothing.safetensors")),
        (ValueError, "broken.*complete", lambda: Policy.load(tmp_path / "broken.safetensors")),
        (ValueError, "missing tensor", lambda: Policy(card, less)),
        (ValueError, "NaN", lambda: Policy(card, nan)),
        (ValueError, "only the tensors", lambda: Policy(card, tensors | {"more": np.zeros(1, np.float32)})),
        (ValueError, "policy.waypoints", lambda: Policy(card | {"waypoints": 0}, tensors)),
        (ValueError, "policy.sizes", lambda: Policy(card | {"waypoints": 9}, tensors)),
        (TypeError, "tensors|float32|array", lambda: Policy(card, {"a": np.zeros(3)})),
        (ValueError, "x: an array", lambda: policy.look(tasks[:1], x)),
        (ValueError, "waypoints", lambda: policy.look(tasks, x[:, :7].copy())),
        (ValueError, "profile", lambda: policy.look(tasks, x, profile="default")),
        (ValueError, "finite", lambda: policy.look(tasks, x * np.float32(np.nan))),
        (ValueError, "x: an array", lambda: policy.look([], x[:0])),
    ):
        with pytest.raises(error, match=part):
            call()
