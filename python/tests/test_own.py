"""What people bring: optimizers, costs, robots with joints and what stands around them."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import sidestep
from sidestep import Robot, Scene

ROBOTS = Path(__file__).parents[2] / "crates/sidestep-io/tests/robots"
POST = {"name": "post", "shapes": [{"cylinder": {"radius": 0.05, "length": 1.5}, "position": [0.45, 0.25, 0.75]}]}
READY, SIDE = [0, -0.785, 0, -2.356, 0, 1.571, 0.785], [1, 0.2, 0, -1.9, 0, 2, 0.8]


@pytest.fixture(scope="module")
def panda():
    joints = [f"panda_joint{i}" for i in range(1, 8)]
    return Robot.from_urdf(ROBOTS / "panda_spherized.urdf", srdf=ROBOTS / "panda.srdf", joints=joints)


def descent(waypoints, dof):
    assert (waypoints, dof) == (10, 2)
    return lambda x, cost, gradient: x - np.float32(0.5) * gradient


def test_an_own_optimizer_is_as_ours():
    tasks = sidestep.suite("easy", 12, seed=3)
    ours = sidestep.plan_batch(tasks, "gd:step=0.5", steps=60)
    assert 0 < sum(plan.solved for plan in ours) < 12
    for one, two in zip(ours, sidestep.plan_batch(tasks, descent, steps=60)):
        assert (one.status, one.iterations) == (two.status, two.iterations)
        np.testing.assert_array_equal(one.waypoints, two.waypoints)
    begun = []

    def counted(waypoints, dof):
        begun.append(waypoints)
        return lambda x, cost, gradient: x

    stuck = next(plan.task for plan in ours if not plan.solved)
    sidestep.plan(stuck, counted, starts=4, steps=3)
    assert len(begun) == 4
    # float64, lists and steps that work in place are as good.
    assert sidestep.plan(tasks[0], lambda n, d: lambda x, u, g: (x - 0.5 * g).tolist(), steps=60).status == ours[0].status


def test_a_policy_plans():
    tasks = sidestep.suite("hard", 30, seed=3)
    policy = sidestep.Policy.load("sidestep-1-small")
    for one, two in zip(sidestep.plan_batch(tasks, policy), sidestep.plan_batch(tasks, "sidestep-1-small")):
        assert one.status == two.status
        np.testing.assert_array_equal(one.waypoints, two.waypoints)


def test_what_an_own_optimizer_does_wrong_is_raised():
    task = sidestep.suite("hard", 1, seed=3)[0]

    def wrong(answer):
        return lambda waypoints, dof: lambda x, cost, gradient: answer(x)

    def broken(waypoints, dof):
        raise RuntimeError("no optimizer today")

    def loud(x):
        raise KeyError("step")

    for error, part, planner in (
        (ValueError, r"its step.*\[3, 2\].*\[10, 2\]", wrong(lambda x: x[:3])),
        (ValueError, "NaN", wrong(lambda x: x * np.nan)),
        (ValueError, "could not convert", wrong(lambda x: "x")),
        (RuntimeError, "no optimizer today", broken),
        (KeyError, "step", wrong(loud)),
        (TypeError, "planner: int", 3),
        (TypeError, "argument", lambda: None),
        (TypeError, "not callable", lambda waypoints, dof: 3),
    ):
        with pytest.raises(error, match=part):
            sidestep.plan(task, planner)
        with pytest.raises(error, match=part):
            sidestep.plan_batch([task] * 5, planner)


def low(path):
    """Points are better where y is small: normalised units, with the ends."""
    slope = np.zeros_like(path[1:-1])
    slope[:, 1] = 0.02
    return 0.02 * float(path[1:-1, 1].sum()), slope


def test_an_own_cost_bends_plans_and_is_part_of_u():
    task = sidestep.Task(((0, 0), (10, 10)), (1, 5), (9, 5))
    plain, bent = (sidestep.plan(task, "gd", steps=60, best=True, cost=cost) for cost in (None, low))
    assert plain.solved and bent.solved
    assert bent.waypoints[1:-1, 1].mean() < plain.waypoints[1:-1, 1].mean() - 0.2
    with_it, without = (sidestep.Objective([task] * 3, cost=cost) for cost in (low, None))
    x = without.straight_lines() + np.float32(0.1)
    (u, slope), (v, slope_v) = with_it.cost_and_gradient(x), without.cost_and_gradient(x)
    np.testing.assert_allclose(u - v, 0.02 * x[:, :, 1].sum(1), rtol=1e-4)
    np.testing.assert_allclose((slope - slope_v)[..., 1], 0.02, rtol=1e-3)
    np.testing.assert_allclose((slope - slope_v)[..., 0], 0, atol=1e-6)


def test_what_an_own_cost_does_wrong_is_raised():
    task = sidestep.suite("easy", 1, seed=3)[0]
    for error, part, cost in (
        (ValueError, "cost: NaN", lambda path: (float("nan"), path[1:-1])),
        (ValueError, r"its gradient.*\[10, 2\]", lambda path: (0.0, path)),
        (ZeroDivisionError, "division", lambda path: 1 / 0),
        ((TypeError, ValueError), "tuple|unpack", lambda path: 1.0),
    ):
        objective = sidestep.Objective([task], cost=cost)
        for call in (
            lambda: sidestep.plan(task, "gd", cost=cost),
            lambda: sidestep.plan_batch([task] * 3, "gd", cost=cost),
            lambda: objective.cost(objective.straight_lines()),
        ):
            with pytest.raises(error, match=part):
                call()


def test_a_robot_among_things(panda):
    assert panda.dof == 7 and panda.joints[0] == "panda_joint1" and panda.limits.shape == (7, 2)
    assert (panda.limits[:, 0] < READY).all() and (panda.limits[:, 1] > READY).all()
    scene = Scene([POST])
    table = {"name": "table", "shapes": [{"box": {"half_extents": [0.4, 0.6, 0.02]}, "position": [0.6, 0, -0.3]}]}
    fuller = scene.with_objects([table])
    assert scene.names == ["post"] and fuller.names == ["post", "table"] and fuller.without(["post"]).names == ["table"]
    empty, posted = (sidestep.plan(panda.task(s, READY, SIDE)) for s in (Scene(), scene))
    assert empty.solved and posted.solved
    assert posted.waypoints.shape[1] == 7 and posted.waypoints.dtype == np.float64
    assert sidestep.certify(panda.task(scene, READY, SIDE), posted.waypoints) is None
    straight = np.array([READY, SIDE], float)
    assert "object 0" in sidestep.certify(panda.task(scene, READY, SIDE), straight)
    assert sidestep.certify(panda.task(Scene(), READY, SIDE), straight) is None


def test_arrays_of_many_joints(panda):
    scene = Scene([POST])
    goals = [SIDE, [0.8, 0.1, 0.1, -2.0, 0, 2, 0.5], [1.2, 0.3, -0.1, -1.7, 0, 1.9, 0.8]]
    tasks = [panda.task(scene, READY, goal, name=f"goal {i}") for i, goal in enumerate(goals)]
    plans = sidestep.plan_batch(tasks)
    assert all(plan.solved for plan in plans)
    objective = sidestep.Objective(tasks, waypoints=6)
    x = objective.straight_lines()
    costs, gradient = objective.cost_and_gradient(x)
    assert x.shape == gradient.shape == (3, 6, 7)
    stepped = sidestep.plan_batch(tasks, lambda n, dof: lambda x, cost, gradient: x - 0.02 * gradient, waypoints=6, steps=5)
    assert [plan.waypoints.shape for plan in stepped if plan.waypoints is not None]


def test_robots_travel(panda, tmp_path):
    again = pickle.loads(pickle.dumps(panda))
    (tmp_path / "panda.json").write_text(panda.to_json())
    for other in (again, Robot.load(tmp_path / "panda.json"), Robot.from_json(panda.to_json())):
        assert other.joints == panda.joints
        one, two = (sidestep.plan(robot.task(Scene([POST]), READY, SIDE)) for robot in (panda, other))
        np.testing.assert_array_equal(one.waypoints, two.waypoints)


def test_mistakes_with_robots_are_named(panda, tmp_path):
    scene = Scene()
    (tmp_path / "bad.urdf").write_text("<robot name='r'><link/></robot>")
    for error, part, call in (
        (ValueError, "bad.urdf", lambda: Robot.from_urdf(tmp_path / "bad.urdf")),
        (ValueError, "nothing.urdf", lambda: Robot.from_urdf("nothing.urdf")),
        (ValueError, "elbow", lambda: Robot.from_urdf(ROBOTS / "panda_spherized.urdf", joints=["elbow"])),
        (ValueError, "start", lambda: panda.task(scene, READY[:6], SIDE)),
        (ValueError, "goal", lambda: panda.task(scene, READY, [float("inf")] * 7)),
        (ValueError, "radius", lambda: Scene([{"name": "ball", "shapes": [{"sphere": {"radius": -1}}]}])),
        (ValueError, "shapes", lambda: Scene([{"name": "ball"}])),
        (TypeError, "JSON", lambda: Scene([{"name": object()}])),
        (ValueError, "Scene.load", lambda: Scene([{"name": "m", "shapes": [{"mesh": {"file": "m.stl"}}]}])),
        (ValueError, "names", lambda: Scene([POST]).without(["table"])),
        (ValueError, "post", lambda: Scene([POST]).with_objects([POST])),
        (ValueError, "nothing.yaml", lambda: Scene.load("nothing.yaml")),
        (ValueError, "format", lambda: Robot.from_json("{}")),
    ):
        with pytest.raises(error, match=part):
            call()
