"""sidestep's plans beside those of OMPL's RRT-Connect for robots with joints, each judged by the same independent checker.

OMPL (its Python wheel) checks states by pinocchio and coal on the same collision geometry, called back from C++: its time is
that of the whole call, callbacks included, and the share that the checks take is told beside it. sidestep's time is that of its
example `arm_plans`, around preparation of the world and planning. Both on one core, one after the other.

    python compare_arms.py --plans plans.jsonl --problems mbm_panda.json --urdf panda_spherized.urdf --srdf panda.srdf \\
        --json ../reports/speed/arms.json

Plans of both are judged at `--per-radian` samples (`judge_arms.py`). Motions of OMPL are checked every 1/32 rad, as VAMP does.
VAMP itself has no wheel that installs here.
"""

import argparse
import json
import os
import sys
import time

import numpy as np
import pinocchio as pin
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from judge_arms import Judge

SECONDS = 5.0


class Planner:
    def __init__(self, judge, joints, problem):
        self.judge, self.joints, self.checks, self.checking = judge, joints, 0, 0.0
        limits = []
        for name in joints:
            joint = judge.model.joints[judge.model.getJointId(name)]
            continuous = joint.nq == 2
            low = -np.pi if continuous else judge.model.lowerPositionLimit[joint.idx_q]
            high = np.pi if continuous else judge.model.upperPositionLimit[joint.idx_q]
            limits.append((low, high))
        self.problem = problem
        self.space = ob.RealVectorStateSpace(len(joints))
        bounds = ob.RealVectorBounds(len(joints))
        for i, (low, high) in enumerate(limits):
            bounds.setLow(i, float(low))
            bounds.setHigh(i, float(high))
        self.space.setBounds(bounds)
        self.space.setLongestValidSegmentFraction(1 / 32 / self.space.getMaximumExtent())

    def valid(self, state):
        begun = time.perf_counter()
        q = self.judge.configuration(self.joints, [state[i] for i in range(len(self.joints))])
        free = not self.judge.collides(q)
        self.checking += time.perf_counter() - begun
        self.checks += 1
        return free

    def plan(self):
        setup = og.SimpleSetup(self.space)
        setup.setStateValidityChecker(self.valid)
        ends = []
        for values in (self.problem["start"], self.problem["goals"][0]):
            state = self.space.allocState()
            for i, value in enumerate(values):
                state[i] = float(value)
            ends.append(state)
        setup.setStartAndGoalStates(*ends)
        setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
        begun = time.perf_counter()
        solved = setup.solve(SECONDS)
        if solved:
            setup.simplifySolution()
        seconds = time.perf_counter() - begun
        if not solved or not setup.haveExactSolutionPath():
            return seconds, None
        states = setup.getSolutionPath().getStates()
        return seconds, [[state[i] for i in range(len(self.joints))] for state in states]


def length(path):
    return float(np.sum(np.linalg.norm(np.diff(np.asarray(path), axis=0), axis=1)))


def percentile(values, share):
    return round(float(np.percentile(values, share)), 1) if values else None


def row(plans, judged):
    faults = [fault for fault in judged.values() if fault]
    times = [plan["us"] for plan in plans.values()]
    return {
        "solved": len(plans),
        "us_p50": percentile(times, 50),
        "us_p95": percentile(times, 95),
        "length_mean": round(float(np.mean([length(plan["path"]) for plan in plans.values()])), 4) if plans else None,
        "collide": len(faults),
        "deepest_mm": round(1000 * max((fault["depth_m"] for fault in faults), default=0.0), 3),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plans", required=True)
    parser.add_argument("--problems", required=True)
    parser.add_argument("--urdf", required=True)
    parser.add_argument("--srdf", required=True)
    parser.add_argument("--meshes")
    parser.add_argument("--per-radian", type=float, default=512)
    parser.add_argument("--most", type=int, help="problems, the first ones")
    parser.add_argument("--json", required=True)
    arguments = parser.parse_args()
    ou.setLogLevel(ou.LOG_NONE)
    ou.RNG.setSeed(1)
    with open(arguments.problems) as file:
        document = json.load(file)
    with open(arguments.plans) as file:
        ours = {plan["problem"]: plan for plan in map(json.loads, file)}
    judge = Judge(arguments.urdf, arguments.srdf, arguments.meshes, document.get("fixed_joints", {}))
    systems = {"sidestep": ({}, {}), "ompl": ({}, {})}
    checks, checking, whole, invalid = [], 0.0, 0.0, 0
    load = os.getloadavg()[0]
    problems = document["problems"][: arguments.most]
    for at, problem in enumerate(problems):
        name = problem.get("name") or f"{problem['set']}/{problem['index']}"
        judge.place(problem)
        ends = [problem["start"], problem["goals"][0]]
        if any(judge.collides(judge.configuration(document["joints"], q)) for q in ends):
            invalid += 1
            continue
        planner = Planner(judge, document["joints"], problem)
        seconds, path = planner.plan()
        checks.append(planner.checks)
        checking, whole = checking + planner.checking, whole + seconds
        theirs = {"us": 1e6 * seconds, "path": path} if path else None
        for system, plan in (("sidestep", ours.get(name)), ("ompl", theirs)):
            if plan:
                plans, judged = systems[system]
                plans[name] = plan
                judged[name] = judge.plan(document["joints"], plan["path"], arguments.per_radian)[1]
        print(f"\r{at + 1} of {len(problems)}", end="", file=sys.stderr)
    print(file=sys.stderr)
    report = {
        "problems": os.path.basename(arguments.problems),
        "robot": os.path.basename(arguments.urdf),
        "count": len(problems),
        "invalid": invalid,
        "per_radian": arguments.per_radian,
        "systems": {system: row(*found) for system, found in systems.items()},
        "ompl_checks_p50": percentile(checks, 50),
        "ompl_share_of_checks": round(checking / whole, 3) if whole else None,
        "load_before": round(load, 1),
        "versions": {"pinocchio": pin.__version__},
    }
    with open(arguments.json, "w") as file:
        json.dump(report, file, indent=1)
        file.write("\n")
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
