"""RLlib's PPO on the environments that are stepped in Rust (`pip install "ray[rllib]" torch "sidestep[gym]"`).

    python rllib.py --iterations 2

RLlib finds the environments by their name, `module:id`, so that runners on other machines register them too; it pins a Gymnasium
of its own, hence an environment of its own. To train policies our own trainer or Stable-Baselines3 is quicker.
"""

import argparse

import gymnasium
import ray
import sidestep.gym  # noqa: F401  registers, for this process
from ray.rllib.algorithms.ppo import PPOConfig

parser = argparse.ArgumentParser()
parser.add_argument("--iterations", type=int, default=5)
parser.add_argument("--envs", type=int, default=64)
args = parser.parse_args()

ray.init(include_dashboard=False, log_to_driver=False, logging_level="ERROR")
config = (
    PPOConfig()
    .environment(
        "sidestep.gym:sidestep/Optimize-v0",
        env_config={"suite": "easy", "tasks": args.envs, "task_seed": 1000, "max_episode_steps": 40},
    )
    .env_runners(
        num_env_runners=0,
        num_envs_per_env_runner=args.envs,
        gym_env_vectorize_mode=gymnasium.VectorizeMode.VECTOR_ENTRY_POINT,
        rollout_fragment_length=40,
    )
    .training(train_batch_size_per_learner=40 * args.envs, minibatch_size=640, num_epochs=2, gamma=0.85, lr=1e-3)
)
algorithm = config.build_algo()
for iteration in range(args.iterations):
    runners = algorithm.train()["env_runners"]
    print(f"iteration {iteration}: {runners['num_env_steps_sampled_lifetime']:.0f} steps, return {runners['episode_return_mean']:.2f}")
algorithm.stop()
ray.shutdown()
