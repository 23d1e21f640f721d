"""Writes golden/ppo.json: what a PPO implementation computes, by PyTorch's automatic differentiation in float64.

Sources: PPO (Schulman et al. 2017, arXiv 1707.06347), GAE (Schulman et al. 2016, arXiv 1506.02438), Adam (Kingma and Ba 2015,
arXiv 1412.6980), Adadelta (Zeiler 2012, arXiv 1212.5701), all in the form that Stable-Baselines3 and PyTorch give them. The GAE
values and a whole update are checked against Stable-Baselines3 itself (which computes in float32) before the file is written.

Conventions: a layer is y = W x + b with weight[out][in]; networks are linear, tanh, linear, tanh, linear; policy and value share
nothing; log-std is one free vector. Parameters, gradients and updated parameters all have the same shape in the file:
{"policy": [{"weight", "bias"} x 3], "value": [{"weight", "bias"} x 3], "log_std": [...]}.

    A_t       = sum_k (gamma lambda)^k delta_{t+k},  delta_t = r_t + gamma v_{t+1} - v_t, both cut at the end of an episode
    ratio     = exp(log pi(a|s) - log pi_old(a|s))
    policy    = -mean(min(ratio A, clip(ratio, 1 - 0.2, 1 + 0.2) A)),  A shifted and scaled per minibatch: (A - mean)/(std + 1e-8),
                std with n - 1
    value     = mean((v - return)^2)
    entropy   = mean over the minibatch of the policy's entropy
    loss      = policy + 0.5 value - entropy_coefficient entropy
    kl        = mean((ratio - 1) - log ratio)
    clipped   = gradient * min(1, 0.5 / (norm + 1e-6)), norm over all parameters together
    Adam      : m, v with beta 0.9, 0.999;  theta -= lr (m / (1 - 0.9^t)) / (sqrt(v / (1 - 0.999^t)) + 1e-5), lr = 3e-4
    Adadelta  : s = 0.9 s + 0.1 g^2;  d = sqrt(u + 1e-6) / sqrt(s + 1e-6) g;  u = 0.9 u + 0.1 d^2;  theta -= lr d, lr = 1
"""

import math
from itertools import pairwise

import numpy as np
import torch
from torch.nn import functional

import golden
import sb3_checks

OBSERVATION, HIDDEN, ACTION, MINIBATCH = 4, 6, 4, 8
CLIP_RANGE, VALUE_COEFFICIENT, GRADIENT_LIMIT = 0.2, 0.5, 0.5
LEARNING_RATE, ADAM_EPSILON = 3e-4, 1e-5

TOLERANCES = {"advantage": 1e-9, "network": 1e-9, "loss": 1e-9, "gradient": 1e-9, "parameters": 1e-9}


# --- networks ---


def draw_network(rng, sizes, spread=0.5):
    """Layers of uniform(-spread, spread) on a grid of 1e-4, so that the file holds them exactly."""
    return [
        {
            "weight": golden.decimals(rng.uniform(-spread, spread, (outputs, inputs)), 4),
            "bias": golden.decimals(rng.uniform(-spread, spread, outputs), 4),
        }
        for inputs, outputs in pairwise(sizes)
    ]


def draw_parameters(rng):
    """Policy and value networks and log-std."""
    return {
        "policy": draw_network(rng, (OBSERVATION, HIDDEN, HIDDEN, ACTION)),
        "value": draw_network(rng, (OBSERVATION, HIDDEN, HIDDEN, 1)),
        "log_std": golden.decimals(rng.uniform(-0.8, 0.3, ACTION), 4),
    }


def to_tensors(tree):
    """The same tree of float64 tensors that record gradients."""
    if isinstance(tree, dict):
        return {key: to_tensors(item) for key, item in tree.items()}
    if isinstance(tree, list):
        return [to_tensors(item) for item in tree]
    return torch.tensor(tree, dtype=torch.float64, requires_grad=True)


def leaves(tree):
    """The tensors of a tree, in the order the file lists them."""
    if isinstance(tree, dict):
        return [leaf for item in tree.values() for leaf in leaves(item)]
    if isinstance(tree, list):
        return [leaf for item in tree for leaf in leaves(item)]
    return [tree]


def like(tree, values):
    """`values` (one per leaf) in the shape of `tree`."""
    values = iter(values)

    def build(node):
        if isinstance(node, dict):
            return {key: build(item) for key, item in node.items()}
        if isinstance(node, list):
            return [build(item) for item in node]
        return next(values).detach().clone()

    return build(tree)


def forward(layers, inputs):
    """Outputs [B, out] of inputs [B, in]."""
    for layer in layers[:-1]:
        inputs = torch.tanh(functional.linear(inputs, layer["weight"], layer["bias"]))
    return functional.linear(inputs, layers[-1]["weight"], layers[-1]["bias"])


def normal(mean, log_std):
    """The diagonal Gaussian; log-probabilities and entropies are sums over the last axis."""
    return torch.distributions.Independent(torch.distributions.Normal(mean, log_std.exp()), 1)


# --- advantages ---


def advantages(rewards, values, dones, last_values, discount, trace):
    """GAE by its definition, a sum of discounted temporal differences per step; [steps, envs] in, [steps, envs] out."""
    steps, envs = rewards.shape
    result = np.zeros((steps, envs))
    for env in range(envs):
        for begin in range(steps):
            weight = 1.0
            for t in range(begin, steps):
                following = values[t + 1, env] if t + 1 < steps else last_values[env]
                alive = 0.0 if dones[t, env] else 1.0
                result[begin, env] += weight * (rewards[t, env] + discount * alive * following - values[t, env])
                weight *= discount * trace * alive
    return result


def advantage_cases(rng):
    """Three environments, six steps, two discounts; episodes end in the middle, at the last step and never."""
    rewards = golden.decimals(-rng.uniform(0.1, 3, (6, 3)), 4)
    values = golden.decimals(rng.normal(-4, 2, (6, 3)), 4)
    last_values = golden.decimals(rng.normal(-4, 2, 3), 4)
    dones = np.zeros((6, 3), dtype=bool)
    dones[[1, 3], 0], dones[5, 1] = True, True
    cases = []
    for discount in (1.0, 0.97):
        result = advantages(rewards, values, dones, last_values, discount, 0.95)
        sb3_checks.check_advantages(rewards, values, dones, last_values, discount, result)
        inputs = {"rewards": rewards, "values": values, "dones": dones, "last_values": last_values}
        cases.append({"gamma": discount, "lambda": 0.95, **inputs, "advantages": result, "returns": result + values})
    return cases


# --- one minibatch ---


def losses(parameters, batch, entropy_coefficient):
    """The loss and its parts."""
    policy = normal(forward(parameters["policy"], batch["observations"]), parameters["log_std"])
    value = forward(parameters["value"], batch["observations"])[:, 0]
    advantage = (batch["advantages"] - batch["advantages"].mean()) / (batch["advantages"].std() + 1e-8)
    log_ratio = policy.log_prob(batch["actions"]) - batch["old_log_probs"]
    ratio = log_ratio.exp()
    surrogate = torch.minimum(ratio * advantage, ratio.clamp(1 - CLIP_RANGE, 1 + CLIP_RANGE) * advantage)
    parts = {
        "policy_loss": -surrogate.mean(),
        "value_loss": functional.mse_loss(value, batch["returns"]),
        "entropy": policy.entropy().mean(),
        "approx_kl": (ratio - 1 - log_ratio).mean(),
        "clip_fraction": ((ratio - 1).abs() > CLIP_RANGE).double().mean(),
    }
    entropy_bonus = entropy_coefficient * parts["entropy"]
    return {"loss": parts["policy_loss"] + VALUE_COEFFICIENT * parts["value_loss"] - entropy_bonus, **parts}


def update_cases(rng):
    """Two Adam steps on one minibatch: plain; with an entropy bonus; with a gradient short enough to be left alone."""
    cases = []
    for name, entropy_coefficient, value_error, wider in (
        ("plain", 0.0, 2.0, 0.0),
        ("entropy-bonus", 0.01, 2.0, 0.0),
        ("short-gradient", 0.01, 0.05, 1.5),
    ):
        start = draw_parameters(rng)
        start["log_std"] = golden.decimals(start["log_std"] + wider, 4)
        batch = draw_batch(rng, to_tensors(start), value_error)
        parameters = to_tensors(start)
        optimizer = torch.optim.Adam(leaves(parameters), lr=LEARNING_RATE, eps=ADAM_EPSILON)
        steps = [update(parameters, optimizer, batch, entropy_coefficient) for _ in range(2)]
        long = steps[0]["gradient_norm"] > GRADIENT_LIMIT
        if long != (value_error > 1):
            raise AssertionError(f"{name}: gradient norm {steps[0]['gradient_norm']}")
        sb3_checks.check_update(start, batch, entropy_coefficient, LEARNING_RATE, steps[0])
        settings = {"entropy_coefficient": entropy_coefficient, "parameters": start}
        cases.append({"name": name, **settings, **batch, "steps": steps})
    return cases


def draw_batch(rng, parameters, value_error):
    """Eight transitions whose probability ratios lie on both sides of both clip bounds."""
    observations = golden.decimals(rng.normal(0, 1, (MINIBATCH, OBSERVATION)), 4)
    with torch.no_grad():
        inputs = torch.tensor(observations)
        policy = normal(forward(parameters["policy"], inputs), parameters["log_std"])
        values = forward(parameters["value"], inputs)[:, 0].numpy()
        actions = golden.decimals(policy.mean.numpy() + rng.normal(0, 0.7, (MINIBATCH, ACTION)), 4)
        log_probs = policy.log_prob(torch.tensor(actions)).numpy()
    # Ratios of about 0.61, 0.74, 0.86, 0.97, 1.03, 1.16, 1.35, 1.65, each once, so that no ratio is near 0.8 or 1.2.
    shift = rng.permutation([-0.5, -0.3, -0.15, -0.03, 0.03, 0.15, 0.3, 0.5])
    advantage = rng.permutation([-1, -1, -1, -1, 1, 1, 1, 1]) * rng.uniform(0.3, 2, MINIBATCH) + 0.2
    batch = {
        "observations": observations,
        "actions": actions,
        "old_log_probs": golden.decimals(log_probs - shift, 6),
        "advantages": golden.decimals(advantage, 4),
        "returns": golden.decimals(values + rng.normal(0, value_error, MINIBATCH), 4),
    }
    return {key: torch.tensor(item) for key, item in batch.items()}


def update(parameters, optimizer, batch, entropy_coefficient):
    """One step in place; what was computed on the way, and the parameters after it."""
    optimizer.zero_grad()
    parts = losses(parameters, batch, entropy_coefficient)
    parts["loss"].backward()
    gradient = like(parameters, [leaf.grad for leaf in leaves(parameters)])
    norm = torch.nn.utils.clip_grad_norm_(leaves(parameters), GRADIENT_LIMIT)
    clipped = like(parameters, [leaf.grad for leaf in leaves(parameters)])
    optimizer.step()
    return {
        **{key: item.item() for key, item in parts.items()},
        "gradient": gradient,
        "gradient_norm": norm.item(),
        "clipped_gradient": clipped,
        "parameters_after": like(parameters, leaves(parameters)),
    }


# --- the rest ---


def network_case(rng):
    """Both networks on five inputs, one of them zero; Gaussian log-probabilities and entropies at the policy's outputs."""
    parameters = draw_parameters(rng)
    inputs = golden.decimals(rng.normal(0, 1.5, (5, OBSERVATION)), 4)
    inputs[0] = 0
    tensors = to_tensors(parameters)
    with torch.no_grad():
        mean, value = (forward(tensors[net], torch.tensor(inputs)) for net in ("policy", "value"))
        actions = golden.decimals(mean.numpy() + rng.normal(0, 1, mean.shape), 4)
        policy = normal(mean, tensors["log_std"])
        log_prob, entropy = policy.log_prob(torch.tensor(actions)), policy.entropy()
    by_hand = np.sum(parameters["log_std"] + 0.5 * math.log(2 * math.pi * math.e))
    np.testing.assert_allclose(entropy, by_hand, rtol=1e-12)
    outputs = {"policy_outputs": mean, "value_outputs": value[:, 0]}
    gaussian = {"actions": actions, "log_probs": log_prob, "entropies": entropy}
    return {"parameters": parameters, "inputs": inputs, **outputs, **gaussian}


def optimizer_case(rng, make):
    """Two steps of an optimizer on a vector of six with given gradients; one gradient is zero, sizes span six decades."""
    start = golden.decimals(rng.normal(0, 1, 6), 4)
    gradients = golden.decimals(rng.normal(0, 1, (2, 6)) * [1e-3, 1e-2, 0.1, 1, 10, 0], 6)
    parameter = torch.tensor(start, requires_grad=True)
    optimizer = make([parameter])
    after = []
    for gradient in gradients:
        parameter.grad = torch.tensor(gradient)
        optimizer.step()
        after.append(parameter.detach().clone())
    return {"parameters": start, "gradients": gradients, "parameters_after": after}


def cloning_cases(rng):
    """Mean squared error between policy outputs and targets, over the minibatch and all action coordinates.

    `mean` clones the policy's mean; `sampled` clones mean + exp(log_std) noise with the noise given, as the paper's code did, and
    so has a gradient for log-std too.
    """
    start = draw_parameters(rng)
    inputs = golden.decimals(rng.normal(0, 1, (MINIBATCH, OBSERVATION)), 4)
    targets = golden.decimals(-0.1 * inputs[:, :ACTION], 5)
    noise = golden.decimals(rng.normal(0, 1, (MINIBATCH, ACTION)), 4)
    cases = []
    for name in ("mean", "sampled"):
        tensors = to_tensors({"policy": start["policy"], "log_std": start["log_std"]})
        outputs = forward(tensors["policy"], torch.tensor(inputs))
        if name == "sampled":
            outputs = outputs + tensors["log_std"].exp() * torch.tensor(noise)
        loss = functional.mse_loss(outputs, torch.tensor(targets))
        loss.backward()
        grads = [torch.zeros_like(leaf) if leaf.grad is None else leaf.grad for leaf in leaves(tensors)]
        data = {"inputs": inputs, "targets": targets, "noise": noise}
        parameters = {"policy": start["policy"], "log_std": start["log_std"]}
        cases.append({"name": name, "parameters": parameters, **data, "loss": loss.item(), "gradient": like(tensors, grads)})
    return cases


def main():
    torch.set_num_threads(1)
    torch.manual_seed(0)
    rng = np.random.default_rng(20222)
    document = {
        "format": "sidestep.oracle.ppo/1",
        "command": "python ppo.py",
        "tolerances": TOLERANCES,
        "advantages": advantage_cases(rng),
        "network": network_case(rng),
        "updates": update_cases(rng),
        "adadelta": {
            "learning_rate": 1.0,
            "rho": 0.9,
            "epsilon": 1e-6,
            **optimizer_case(rng, lambda group: torch.optim.Adadelta(group, lr=1.0, rho=0.9, eps=1e-6)),
        },
        "adam": {
            "learning_rate": LEARNING_RATE,
            "betas": [0.9, 0.999],
            "epsilon": ADAM_EPSILON,
            **optimizer_case(rng, lambda group: torch.optim.Adam(group, lr=LEARNING_RATE, eps=ADAM_EPSILON)),
        },
        "cloning": cloning_cases(rng),
    }
    golden.write("ppo.json", document)


if __name__ == "__main__":
    main()
