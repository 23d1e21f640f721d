"""The training environments: Gymnasium's own checks, and the native batch against its own single environments."""

import threading
import warnings

import numpy as np
import pytest
import sidestep

gym = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

ID = "sidestep.gym:sidestep/Optimize-v0"


def test_gymnasium_accepts_the_environment():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*infinity.*")  # a gradient has no bound
        env = gym.make(ID, suite="easy", tasks=1)
        check_env(env.unwrapped, skip_render_check=True)
    assert env.spec.max_episode_steps == 200
    assert env.action_space.shape == (20,) and env.observation_space.shape == (20,)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED])
def test_the_native_batch_is_gymnasiums_own(mode):
    settings = {"suite": "easy", "tasks": 1, "task_seed": 4}
    native = gym.make_vec(ID, num_envs=3, max_episode_steps=7, autoreset_mode=mode, **settings)
    assert native.metadata["autoreset_mode"] is mode
    single = lambda: gym.make(ID, max_episode_steps=7, **settings)  # noqa: E731
    plain = SyncVectorEnv([single] * 3, autoreset_mode=mode)
    (a, _), (b, _) = native.reset(seed=0), plain.reset(seed=0)
    np.testing.assert_array_equal(a, b)
    rng, ends = np.random.default_rng(0), 0
    for step in range(60):
        action = (0.1 * rng.normal(size=(3, 20))).astype(np.float32)
        one, two = native.step(action), plain.step(action)
        for part, (x, y) in enumerate(zip(one[:4], two[:4])):
            np.testing.assert_allclose(x, y, rtol=1e-6, err_msg=f"{mode} step {step} part {part}")
        ended = one[2] | one[3]
        ends += int(ended.sum())
        assert ("final_obs" in one[4]) == ("final_obs" in two[4])
        if "final_obs" in one[4]:
            np.testing.assert_array_equal(one[4]["_final_obs"], two[4]["_final_obs"])
            for x, y in zip(one[4]["final_obs"], two[4]["final_obs"]):
                assert (x is None) == (y is None) and (x is None or np.array_equal(x, y))
        if mode is AutoresetMode.DISABLED and ended.any():
            (a, _), (b, _) = (envs.reset(options={"reset_mask": ended.copy()}) for envs in (native, plain))
            np.testing.assert_allclose(a, b, rtol=1e-6)
    assert ends > 0


def test_own_tasks_and_own_reward():
    tasks = sidestep.suite("hard", 4, seed=9)
    seen = []

    def reward(cost, terminated):
        seen.append(cost.copy())
        return np.where(terminated, 5, -1).astype(np.float32)

    envs = gym.make_vec(ID, num_envs=4, tasks=tasks, reward=reward, max_episode_steps=10)
    envs.reset(seed=0)
    _, rewards, terminated, _, _ = envs.step(np.zeros((4, 20), np.float32))
    assert set(rewards[~terminated]) <= {-1.0} and len(seen) == 1 and (seen[0] > 0).all()
    views = gym.make_vec(ID, num_envs=2, suite="easy", tasks=2, parts=["gradient", "trajectory"])
    assert views.single_observation_space.shape[0] > 20


def test_descending_lowers_the_cost():
    envs = gym.make_vec(ID, num_envs=64, suite="easy", tasks=64, autoreset_mode=AutoresetMode.SAME_STEP)
    seen, _ = envs.reset(seed=0)
    solved = 0
    for _ in range(60):
        seen, _, terminated, _, _ = envs.step(-0.1 * seen)
        solved += int(terminated.sum())
    assert solved > 64


def test_statistics_wrappers_work():
    envs = gym.wrappers.vector.RecordEpisodeStatistics(gym.make_vec(ID, num_envs=16, max_episode_steps=5))
    envs.reset(seed=1)
    episodes = 0
    for _ in range(20):
        *_, infos = envs.step(np.zeros((16, 20), np.float32))
        episodes += int(infos["_episode"].sum()) if "_episode" in infos else 0
    assert episodes >= 16


def test_a_picture():
    pytest.importorskip("matplotlib")
    env = gym.make(ID, tasks=1, render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.dtype == np.uint8 and picture.shape == (320, 320, 3) and picture.std() > 1


def test_misuse_is_told():
    tasks = sidestep.suite("easy", 2)
    batch = sidestep.Batch(tasks, 8)
    for part, call in (
        ("actions: an array", lambda: batch.step(np.zeros((7, 20), np.float32))),
        ("C-contiguous", lambda: batch.step(np.zeros((20, 8), np.float32).T)),
        (r"actions\[2, 3\]: NaN", lambda: batch.step(np.where(np.arange(160).reshape(8, 20) == 43, np.nan, 0).astype(np.float32))),
        ("count", lambda: sidestep.Batch(tasks, 0)),
        ("tasks", lambda: sidestep.Batch([], 1)),
        ("reset", lambda: sidestep.Batch(tasks, 1, reset="always")),
        ("parts|observation", lambda: sidestep.Batch(tasks, 1, parts=["gradent"])),
        ("mask", lambda: batch.reset([True])),
        ("waypoints", lambda: sidestep.Batch(tasks, 1, waypoints=0)),
    ):
        with pytest.raises(ValueError, match=part):
            call()
    with pytest.raises(TypeError):
        batch.step(np.zeros((8, 20), np.float64))
    envs = gym.make_vec(ID, num_envs=2)
    with pytest.raises(RuntimeError, match="reset"):
        envs.unwrapped.step(np.zeros((2, 20), np.float32))
    envs.reset()
    envs.close()
    with pytest.raises(RuntimeError, match="closed"):
        envs.unwrapped.step(np.zeros((2, 20), np.float32))


def test_two_threads_on_one_batch_are_refused_not_wrong():
    batch = sidestep.Batch(sidestep.suite("hard", 64), 1024)
    actions, errors = np.zeros((1024, 20), np.float32), []

    def work():
        for _ in range(20):
            try:
                batch.step(actions)
            except RuntimeError as error:
                errors.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert all("borrowed" in error for error in errors)
