"""Tasks, plans, objectives and the program, as people in Python meet them."""

import copy
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
import sidestep

ROBOTS = Path(__file__).parents[2] / "crates/sidestep-io/tests/robots"
BOUNDS = ((0.0, 0.0), (10.0, 10.0))


def block(**settings):
    return sidestep.Task(BOUNDS, (1, 1), (9, 9), rects=[(3, 2, 7, 7)], name="block", **settings)


def test_a_plan_is_certified_arrays():
    plan = sidestep.plan(block())
    assert plan.solved and plan.status == "solved" and plan.reason == ""
    assert plan.waypoints.dtype == np.float64 and plan.waypoints.shape[1] == 2
    assert plan.waypoints[0].tolist() == [1, 1] and plan.waypoints[-1].tolist() == [9, 9]
    assert sidestep.certify(plan.task, plan.waypoints) is None
    length, shortest = sidestep.shortest_path(block())
    assert length <= plan.length + 1e-9 and shortest.shape[1] == 2
    assert plan.clearance > 0 and plan.time_us > 0
    straight = np.array([[1.0, 1.0], [9.0, 9.0]])
    assert "obstacle 0" in sidestep.certify(block(), straight)


def test_what_is_not_solved_says_why():
    wall = sidestep.Task(BOUNDS, (1, 1), (9, 9), rects=[(4, -1, 5, 11)])
    plan = sidestep.plan(wall)
    assert plan.status == "unsolvable" and "separate" in plan.reason and plan.length is None
    assert sidestep.shortest_path(wall) is None
    assert sidestep.plan(block().between(start=(4, 4))).status == "invalid"
    stuck = sidestep.plan(block(), "gd", steps=0, trace=True)
    assert stuck.status == "unsolved" and "obstacle 0" in stuck.reason and stuck.trace.shape == (1, 12, 2)


def test_every_way_to_make_a_task_plans():
    grid = np.zeros((10, 10), bool)
    grid[:7, 5] = True
    for task in (
        block(robot_radius=0.2),
        sidestep.Task(BOUNDS, (1, 1), (9, 1), circles=[(5, 1, 2)]),
        sidestep.Task(BOUNDS, (1, 1), (9, 1), polygons=[[(4, 0), (6, 0), (5, 4)]]),
        sidestep.Task(BOUNDS, (1, 1), (9, 1), grid=grid),
        sidestep.Task(BOUNDS, (1, 1), (9, 1), grid=np.ascontiguousarray(grid.T).T),
    ):
        assert sidestep.plan(task).solved, task
        assert pickle.loads(pickle.dumps(task)).to_json() == task.to_json()


def test_files_of_the_program(tmp_path):
    tasks = sidestep.suite("easy", 5, seed=1)
    sidestep.write(tmp_path / "tasks.jsonl", tasks)
    again = sidestep.read(tmp_path / "tasks.jsonl")
    assert [t.to_json() for t in again] == [t.to_json() for t in tasks]
    (tmp_path / "room.pgm").write_bytes(b"P5\n4 4\n255\n" + bytes([255] * 16))
    (task,) = sidestep.read(tmp_path / "room.pgm", start=(1, 1), goal=(3, 3))
    assert sidestep.plan(task).solved
    with pytest.raises(ValueError, match="no start and goal"):
        sidestep.read(tmp_path / "room.pgm")
    with pytest.raises(ValueError, match="nothing.json"):
        sidestep.read(tmp_path / "nothing.json")


def test_robots_with_joints(tmp_path):
    problems = {
        "format": "sidestep.problems/1",
        "robot": "panda",
        "joints": [f"panda_joint{i}" for i in range(1, 8)],
        "problems": [
            {
                "name": "past the post",
                "start": [0, -0.785, 0, -2.356, 0, 1.571, 0.785],
                "goals": [[1, 0.2, 0, -1.9, 0, 2, 0.8]],
                "objects": [
                    {"name": "post", "shapes": [{"cylinder": {"radius": 0.05, "length": 1.5}, "position": [0.45, 0.25, 0.75]}]}
                ],
            }
        ],
    }
    (tmp_path / "problems.json").write_text(json.dumps(problems))
    robot = {"urdf": ROBOTS / "panda_spherized.urdf", "srdf": ROBOTS / "panda.srdf"}
    (task,) = sidestep.read_problems(tmp_path / "problems.json", **robot)
    assert task.dof == 7 and task.coordinates[0] == "panda_joint1" and task.bounds is None
    plan = sidestep.plan(task)
    assert plan.solved and plan.waypoints.shape[1] == 7
    objective = sidestep.Objective([task], waypoints=6)
    costs, gradient = objective.cost_and_gradient(objective.straight_lines())
    assert gradient.shape == (1, 6, 7) and np.isfinite(costs).all()


def test_a_batch_is_its_tasks_one_by_one():
    tasks = sidestep.suite("hard", 40, seed=5)
    for planner in ("auto", "gd", "rrt-connect"):
        plans = sidestep.plan_batch(tasks, planner)
        assert len(plans) == 40
        alone = sidestep.plan(tasks[0], planner)
        assert plans[0].status == alone.status
        if alone.solved:
            np.testing.assert_array_equal(plans[0].waypoints, alone.waypoints)
    assert sum(plan.solved for plan in sidestep.plan_batch(tasks)) >= 35


def test_the_objective_slopes_as_it_falls():
    tasks = sidestep.suite("easy", 6, seed=2)
    objective = sidestep.Objective(tasks, waypoints=8)
    x = objective.straight_lines()
    assert x.shape == objective.shape == (6, 8, 2)
    costs, gradient = objective.cost_and_gradient(x)
    np.testing.assert_array_equal(costs, objective.cost(x))
    assert (objective.cost(x - 1e-3 * gradient) <= costs + 1e-6).all()
    points = objective.to_task(x)
    assert points.shape == (6, 10, 2)
    np.testing.assert_allclose(points[:, 0], [task.start for task in tasks])
    np.testing.assert_allclose(objective.to_normalised(points[:, 1:-1].copy()), x, atol=1e-5)
    for task, free, path in zip(tasks, objective.certified(x), points):
        assert free == (sidestep.certify(task, path) is None)


def test_own_optimizer_in_python():
    tasks = sidestep.suite("easy", 20, seed=3)
    objective = sidestep.Objective(tasks)
    x = objective.straight_lines()
    before = objective.certified(x).sum()
    for _ in range(100):
        x -= 0.1 * objective.cost_and_gradient(x)[1]
    assert objective.certified(x).sum() >= before


def test_mistakes_are_named():
    task = block()
    objective = sidestep.Objective([task])
    for error, part, call in (
        (ValueError, "planner", lambda: sidestep.plan(task, "gdd")),
        (ValueError, "steps", lambda: sidestep.plan(task, steps=10**12)),
        (ValueError, "profile", lambda: sidestep.plan(task, profile="papr")),
        (ValueError, "budget_ms", lambda: sidestep.plan(task, budget_ms=-1)),
        (ValueError, "margin", lambda: sidestep.plan(task, margin=-1.0)),
        (ValueError, "policy", lambda: sidestep.plan(task, "learned:nothing.safetensors")),
        (ValueError, "suite", lambda: sidestep.suite("eazy", 1)),
        (ValueError, "count", lambda: sidestep.suite("easy", 10**9)),
        (ValueError, r"rects\[0\].max", lambda: sidestep.Task(BOUNDS, (1, 1), (9, 9), rects=[(3, 2, 1, 7)])),
        (ValueError, "start", lambda: sidestep.Task(BOUNDS, (1, float("nan")), (9, 9))),
        (ValueError, "start", lambda: task.between(start=(1, 2, 3))),
        (ValueError, "grid", lambda: sidestep.Task(BOUNDS, (1, 1), (9, 9), grid=np.zeros((0, 0), bool))),
        (TypeError, "grid", lambda: sidestep.Task(BOUNDS, (1, 1), (9, 9), grid=np.zeros((2, 2)))),
        (TypeError, "task", lambda: sidestep.plan("block")),
        (TypeError, "seed", lambda: sidestep.plan(task, seed=1.5)),
        (ValueError, "tasks", lambda: sidestep.Objective([])),
        (ValueError, "x: an array", lambda: objective.cost(np.zeros((1, 9, 2), np.float32))),
        (TypeError, "x", lambda: objective.cost(np.zeros((1, 10, 2)))),
        (TypeError, "x", lambda: objective.cost(np.zeros((10, 2), np.float32))),
        (ValueError, r"x\[0, 3, 1\]", lambda: objective.cost(np.where(np.arange(20).reshape(1, 10, 2) == 7, np.nan, 0).astype(np.float32))),
        (ValueError, "path", lambda: sidestep.certify(task, np.zeros((3, 3)))),
        (ValueError, "nothing", lambda: sidestep.read("nothing")),
    ):
        with pytest.raises(error, match=part):
            call()


def test_strides_do_not_matter():
    objective = sidestep.Objective(sidestep.suite("easy", 4, seed=2))
    x = objective.straight_lines()
    turned = np.ascontiguousarray(x.transpose(2, 1, 0)).transpose(2, 1, 0)
    assert not turned.flags.c_contiguous
    np.testing.assert_array_equal(objective.cost(turned), objective.cost(x))


def test_the_interpreter_is_free_while_rust_works():
    tasks = sidestep.suite("hard", 200, seed=1)
    ticks, stop = [0], threading.Event()

    def tick():
        while not stop.is_set():
            ticks[0] += 1
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    while time.perf_counter() - begin < 0.5:
        sidestep.plan_batch(tasks, "gd")
    stop.set()
    thread.join()
    assert ticks[0] > 20, ticks


def test_ctrl_c_ends_a_plan():
    code = (
        "import sidestep, signal\n"
        # A shell that runs in the background lets its children ignore it.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "task = sidestep.Task(((0, 0), (10, 10)), (1, 1), (9, 9), rects=[(2, 0.5, 8, 9.5)])\n"
        "print('ready', flush=True)\n"
        "try:\n"
        "    sidestep.plan(task, 'gd', steps=100_000_000, best=True)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted')\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=20)
    assert out == "interrupted\n" and process.returncode == 0


def test_pictures():
    pytest.importorskip("matplotlib").use("agg")
    ax = sidestep.plot(sidestep.plan(block(), "gd", trace=True))
    assert ax.get_title().startswith("Plan(") and len(ax.patches) == 1


def test_the_program_comes_along(tmp_path):
    words = [sys.executable, "-m", "sidestep", "generate", "--suite", "easy", "--count", "2", "--seed", "1", "--out", "tasks.jsonl"]
    answer = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert len(sidestep.read(tmp_path / "tasks.jsonl")) == 2
    answer = subprocess.run([sys.executable, "-m", "sidestep", "plan", "/no/such"], capture_output=True)
    assert answer.returncode == 2
    assert (resources.files("sidestep") / "py.typed").is_file()


def test_stubs_are_what_the_module_has():
    pytest.importorskip("mypy")
    answer = subprocess.run([sys.executable, "-m", "mypy.stubtest", "sidestep._sidestep"], capture_output=True, text=True)
    assert answer.returncode == 0, answer.stdout + answer.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_process_has_threads_of_its_own():
    """The threads of the process that forked are not in the other one; whoever waited for them would wait for ever."""
    code = (
        "import os, sys, warnings, sidestep\n"
        "warnings.simplefilter('ignore')\n"
        "tasks = sidestep.suite('hard', 20, seed=3)\n"
        "def work():\n"
        "    plans = sidestep.plan_batch(tasks, 'gd', starts=3)\n"
        "    objective = sidestep.Objective(tasks)\n"
        "    x = objective.straight_lines()\n"
        "    batch = sidestep.Batch(tasks, 64)\n"
        "    batch.step(0 * batch.reset())\n"
        "    return [p.status for p in plans], objective.cost(x).sum(), sidestep.plan(tasks[0], starts=5).status\n"
        "here = work()\n"
        "for _ in range(2):\n"
        "    child = os.fork()\n"
        "    if child == 0:\n"
        "        os._exit(0 if work() == here == work() else 1)\n"
        "    assert os.waitpid(child, 0)[1] == 0\n"
        "assert work() == here\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0, answer.stderr


def test_distances_are_those_of_the_body():
    task = sidestep.Task(BOUNDS, (1, 5), (9, 5), circles=[(5, 5, 2)], robot_radius=0.5)
    points = np.array([[5, 8.2], [1.5, 5], [5, 6], [0.7, 1], [8, 8]])
    found, gradient = sidestep.distances(task, points)
    away = np.hypot(*(points - 5).T) - 2.5
    wall = np.minimum(points, 10 - points).min(1) - 0.5
    np.testing.assert_allclose(found, np.minimum(away, wall), atol=1e-4)
    np.testing.assert_allclose(gradient[2:4], [[0, 1], [1, 0]], atol=1e-3)
    free = [sidestep.plan(task.between(start=p)).status != "invalid" for p in points]
    assert free == [d > 0 for d in found]
    for error, part, call in (
        (ValueError, "points", lambda: sidestep.distances(task, np.zeros((3, 3)))),
        (ValueError, "finite", lambda: sidestep.distances(task, points * np.nan)),
        (TypeError, "points", lambda: sidestep.distances(task, points.astype(np.float32))),
    ):
        with pytest.raises(error, match=part):
            call()
    assert [a.shape for a in sidestep.distances(task, points[:0])] == [(0,), (0, 2)]


def test_what_cannot_be_pickled_or_copied_says_so():
    task = block()
    for thing in (sidestep.plan(task), sidestep.Objective([task]), sidestep.Batch([task], 1)):
        for call in (pickle.dumps, copy.copy, copy.deepcopy):
            with pytest.raises(TypeError, match="pickle"):
                call(thing)
