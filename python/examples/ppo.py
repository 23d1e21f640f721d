"""PPO on a page (after CleanRL, https://github.com/vwxyzjn/cleanrl), on the environments that are stepped in Rust.

    python ppo.py --steps 80000 --out mine.safetensors
    sidestep bench --suite easy --seeds 7 --planner learned:mine.safetensors

The settings are those of experiments/paper-80k.toml, after it began with 64 units and mu 0.1. The environments reset in the step
that ends an episode; a truncated episode's last observation is worth what the critic says of it.
"""

import argparse

import gymnasium
import numpy as np
import sidestep
import torch
from sidestep.torch import perceptron
from torch import nn

parser = argparse.ArgumentParser()
parser.add_argument("--steps", type=int, default=80_000)
parser.add_argument("--envs", type=int, default=100)
parser.add_argument("--suite", default="easy")
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", default="ppo.safetensors")
args = parser.parse_args()
HORIZON, GAMMA, LAMBDA, CLIP, EPOCHS, BATCH, RATE, UNITS = 40, 0.85, 0.95, 0.2, 4, 500, 1e-3, 64
torch.manual_seed(args.seed)

envs = gymnasium.make_vec(
    "sidestep.gym:sidestep/Optimize-v0",
    num_envs=args.envs,
    suite=args.suite,
    tasks=args.envs,
    task_seed=1000 + args.seed,
    mu=0.1,
    max_episode_steps=HORIZON,
    autoreset_mode="SameStep",
)
inputs, outputs = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]


def network(last: int, gain: float) -> nn.Sequential:
    layers = [nn.Linear(inputs, UNITS), nn.Tanh(), nn.Linear(UNITS, UNITS), nn.Tanh(), nn.Linear(UNITS, last)]
    for layer, scale in zip(layers[::2], (2**0.5, 2**0.5, gain)):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


actor, critic = network(outputs, 0.01), network(1, 1.0)
log_std = nn.Parameter(torch.full((outputs,), -1.0))
parameters = [*actor.parameters(), *critic.parameters(), log_std]
adam = torch.optim.Adam(parameters, RATE, eps=1e-5)


def act(seen: torch.Tensor) -> torch.distributions.Normal:
    return torch.distributions.Normal(actor(seen), log_std.exp())


def value(seen: torch.Tensor) -> torch.Tensor:
    return critic(seen).squeeze(-1)


seen = torch.from_numpy(envs.reset(seed=args.seed)[0])
for update in range(max(1, args.steps // (args.envs * HORIZON))):
    rows = {name: [] for name in ("seen", "action", "log_p", "reward", "value", "next")}
    ends, solved = [], 0
    with torch.no_grad():
        for _ in range(HORIZON):
            chosen = act(seen)
            action = chosen.sample()
            after, reward, terminated, truncated, infos = envs.step(action.numpy())
            # What the step led to, before the next episode began.
            final = torch.from_numpy(after.copy())
            for index in np.flatnonzero(infos.get("_final_obs", [])):
                final[index] = torch.from_numpy(infos["final_obs"][index])
            worth = value(final) * torch.from_numpy(~terminated)
            for name, row in zip(rows, (seen, action, chosen.log_prob(action).sum(-1), torch.from_numpy(reward), value(seen), worth)):
                rows[name].append(row)
            ends.append(torch.from_numpy(terminated | truncated))
            solved += int(terminated.sum())
            seen = torch.from_numpy(after)
    data = {name: torch.stack(row) for name, row in rows.items()}
    advantage, carried = torch.zeros_like(data["reward"]), torch.zeros(args.envs)
    for t in reversed(range(HORIZON)):
        delta = data["reward"][t] + GAMMA * data["next"][t] - data["value"][t]
        carried = advantage[t] = delta + GAMMA * LAMBDA * ~ends[t] * carried
    target = (advantage + data["value"]).flatten()
    flat = {name: data[name].flatten(0, 1) for name in ("seen", "action", "log_p")}
    for _ in range(EPOCHS):
        for batch in torch.randperm(len(target)).split(BATCH):
            gain = advantage.flatten()[batch]
            gain = (gain - gain.mean()) / (gain.std() + 1e-8)
            ratio = (act(flat["seen"][batch]).log_prob(flat["action"][batch]).sum(-1) - flat["log_p"][batch]).exp()
            objective = torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
            loss = 0.5 * (value(flat["seen"][batch]) - target[batch]).square().mean() - objective
            adam.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(parameters, 0.5)
            adam.step()
    print(f"update {update}: {solved} of {int(torch.stack(ends).sum())} episodes that ended were solved", flush=True)

layers = [layer for layer in actor if isinstance(layer, nn.Linear)]
made = {"by": "python/examples/ppo.py", "steps": args.steps, "seed": args.seed}
perceptron(layers, observation=["gradient"], training=made).save(args.out)
plans = sidestep.plan_batch(sidestep.suite(args.suite, 200, seed=7), f"learned:{args.out}")
print(f"{args.out}: {sum(plan.solved for plan in plans)} of {len(plans)} tasks certified")
