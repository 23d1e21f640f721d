"""Judges plans of robots with joints by other people's code: kinematics by pinocchio, collisions by coal, dense samples.

A plan is a polyline in joint space; each of its motions is sampled at least `--per-radian` times a radian (Euclidean, in joint
space), ends included, and each sample is checked against the world and against the robot itself: on the URDF's own collision
geometry, spheres or meshes. Nothing here imports sidestep, and nothing is taken from its certificate.

    python judge_arms.py --plans plans.jsonl --problems mbm_panda.json --urdf panda_spherized.urdf --srdf panda.srdf
    python judge_arms.py --plans plans.jsonl --problems mbm_panda.json --urdf panda.urdf --srdf panda.srdf --meshes DIR

A line of the plans is {"problem": name, "joints": [names], "path": [[numbers]]}; a name is that of sidestep.problems/1, or set/index.
Cylinders are the true ones, with flat ends. The report says for each plan that collides where, with what and how deep.
"""

import argparse
import json
import multiprocessing
import sys
import time

import coal
import numpy as np
import pinocchio as pin


def rotation_of(obstacle):
    if "rpy" in obstacle:
        return pin.rpy.rpyToMatrix(np.array(obstacle["rpy"], dtype=float))
    if "quaternion_xyzw" in obstacle:
        x, y, z, w = obstacle["quaternion_xyzw"]
    else:
        w, x, y, z = obstacle.get("quaternion_wxyz", obstacle.get("quaternion", [1, 0, 0, 0]))
    return pin.Quaternion(w, x, y, z).normalized().matrix()


def shape_of(obstacle):
    """coal's shape for one of a problem's, in either JSON form."""
    kind = obstacle.get("shape") or next(k for k in ("box", "cylinder", "sphere", "capsule") if k in obstacle)
    sizes = obstacle if "shape" in obstacle else obstacle[kind]
    if kind == "box":
        return coal.Box(*(2 * np.array(sizes["half_extents"])))
    if kind == "sphere":
        return coal.Sphere(sizes["radius"])
    if kind == "cylinder":
        return coal.Cylinder(sizes["radius"], sizes["length"])
    return coal.Capsule(sizes["radius"], sizes["length"])


def obstacles_of(problem):
    for obstacle in problem.get("obstacles", []):
        yield obstacle["name"], obstacle
    for entry in problem.get("objects", []):
        for shape in entry["shapes"]:
            yield entry["name"], shape


class Judge:
    """One robot; a world at a time."""

    def __init__(self, urdf, srdf, meshes, fixed_joints):
        packages = [meshes] if meshes else []
        self.model = pin.buildModelFromUrdf(urdf)
        self.body = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION, package_dirs=packages)
        self.body.addAllCollisionPairs()
        pin.removeCollisionPairs(self.model, self.body, srdf)
        self.self_pairs = [(pair.first, pair.second) for pair in self.body.collisionPairs]
        self.robot_parts = self.body.ngeoms
        self.rest = pin.neutral(self.model)
        for name, value in fixed_joints.items():
            if self.model.existJointName(name):
                self.set(self.rest, name, np.ravel(value)[0])

    def set(self, q, name, value):
        joint = self.model.joints[self.model.getJointId(name)]
        if joint.nq == 2:  # continuous: a point of the unit circle
            q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            q[joint.idx_q] = value

    def configuration(self, joints, values):
        q = self.rest.copy()
        for name, value in zip(joints, values):
            self.set(q, name, value)
        return q

    def place(self, problem):
        """The robot with this problem's world beside it."""
        self.scene = self.body.copy()
        for i, (name, obstacle) in enumerate(obstacles_of(problem)):
            pose = pin.SE3(rotation_of(obstacle), np.array(obstacle.get("position", [0, 0, 0]), dtype=float))
            geometry = pin.GeometryObject(f"world/{i}/{name}", 0, 0, pose, shape_of(obstacle))
            at = self.scene.addGeometryObject(geometry)
            for part in range(self.robot_parts):
                # What does not move is nobody's fault, as in every planner: the base may stand on a table.
                if self.scene.geometryObjects[part].parentJoint != 0:
                    self.scene.addCollisionPair(pin.CollisionPair(part, at))
        self.data = self.model.createData()
        self.scene_data = pin.GeometryData(self.scene)

    def collides(self, q):
        return pin.computeCollisions(self.model, self.data, self.scene, self.scene_data, q, True)

    def worst(self, q):
        """The deepest pair: its names and depth (m)."""
        pin.computeDistances(self.model, self.data, self.scene, self.scene_data, q)
        distances = [result.min_distance for result in self.scene_data.distanceResults]
        at = int(np.argmin(distances))
        pair = self.scene.collisionPairs[at]
        names = [self.scene.geometryObjects[i].name for i in (pair.first, pair.second)]
        return names, -float(distances[at])

    def plan(self, joints, path, per_radian):
        """What is wrong with a plan, the deepest of its samples first told; nothing if it is free."""
        path = np.asarray(path, dtype=float)
        samples, deepest = 0, None
        for i, (a, b) in enumerate(zip(path[:-1], path[1:])):
            count = max(1, int(np.ceil(np.linalg.norm(b - a) * per_radian)))
            for t in np.arange(0 if i == 0 else 1, count + 1) / count:
                q = self.configuration(joints, a + t * (b - a))
                samples += 1
                if self.collides(q):
                    names, depth = self.worst(q)
                    if deepest is None or depth > deepest["depth_m"]:
                        deepest = {"motion": i, "share": float(t), "pair": names, "depth_m": depth}
        return samples, deepest


def judge_some(job):
    arguments, fixed, problems, plans = job
    judge = Judge(arguments.urdf, arguments.srdf, arguments.meshes, fixed)
    verdicts = []
    for plan in plans:
        judge.place(problems[plan["problem"]])
        samples, fault = judge.plan(plan["joints"], plan["path"], arguments.per_radian)
        verdicts.append({"problem": plan["problem"], "samples": samples, "fault": fault})
    return verdicts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plans", required=True)
    parser.add_argument("--problems", required=True)
    parser.add_argument("--urdf", required=True)
    parser.add_argument("--srdf", required=True)
    parser.add_argument("--meshes", help="the folder under which package:// paths are found")
    parser.add_argument("--per-radian", type=float, default=512)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--json", help="write the report here")
    arguments = parser.parse_args()
    with open(arguments.problems) as file:
        document = json.load(file)
    problems = {p.get("name") or f"{p['set']}/{p['index']}": p for p in document["problems"]}
    with open(arguments.plans) as file:
        plans = [json.loads(line) for line in file if line.strip()]
    unknown = [plan["problem"] for plan in plans if plan["problem"] not in problems]
    if unknown:
        sys.exit(f"{arguments.plans}: no problem {unknown[0]!r} in {arguments.problems}")
    begun = time.time()
    fixed = document.get("fixed_joints", {})
    jobs = [(arguments, fixed, problems, plans[i :: arguments.processes]) for i in range(arguments.processes)]
    with multiprocessing.Pool(arguments.processes) as pool:
        verdicts = [verdict for some in pool.map(judge_some, jobs) for verdict in some]
    faults = [verdict for verdict in verdicts if verdict["fault"]]
    report = {
        "problems": arguments.problems.split("/")[-1],
        "robot": arguments.urdf.split("/")[-1],
        "per_radian": arguments.per_radian,
        "plans": len(verdicts),
        "samples": sum(verdict["samples"] for verdict in verdicts),
        "collide": len(faults),
        "deepest_m": max((verdict["fault"]["depth_m"] for verdict in faults), default=0.0),
        "faults": faults,
        "versions": {"pinocchio": pin.__version__, "coal": coal.__version__},
        "seconds": round(time.time() - begun, 1),
    }
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump(report, file, indent=1)
            file.write("\n")
    print(f"{report['plans']} plans, {report['samples']} samples: {report['collide']} collide, "
          f"at most {1000 * report['deepest_m']:.3f} mm deep")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
