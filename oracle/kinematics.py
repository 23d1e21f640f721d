"""Golden forward kinematics by pinocchio (https://github.com/stack-of-tasks/pinocchio, BSD-2-Clause).

    python oracle/kinematics.py            # writes oracle/golden/kinematics.json

For each robot a few configurations of its joints that move by themselves, and the pose of every link in the root
link's frame: rotation row-major, then translation. Continuous joints are given as angles; mimics are worked out
here from the file, since pinocchio's reader leaves them free.
"""

import json
import pathlib
import xml.etree.ElementTree as xml

import numpy as np
import pinocchio

ROOT = pathlib.Path(__file__).resolve().parent
ROBOTS = ROOT.parent / "crates" / "sidestep-io" / "tests" / "robots"


def golden(path: pathlib.Path, seed: int) -> dict:
    robot = xml.parse(path).getroot()
    joints = {joint.get("name"): joint for joint in robot.findall("joint")}
    mimics = {name: joint.find("mimic") for name, joint in joints.items()}
    moving = [n for n, j in joints.items() if j.get("type") != "fixed" and mimics[n] is None]
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    rng = np.random.default_rng(seed)

    def value(name: str, values: dict) -> float:
        if name in values:
            return values[name]
        mimic = mimics[name]
        inner = value(mimic.get("joint"), values)
        return float(mimic.get("multiplier", 1)) * inner + float(mimic.get("offset", 0))

    samples = []
    for _ in range(8):
        values = {}
        for name in moving:
            limit = joints[name].find("limit")
            continuous = joints[name].get("type") == "continuous"
            low, high = (-3.1, 3.1) if continuous else (float(limit.get("lower")), float(limit.get("upper")))
            values[name] = float(rng.uniform(low, high))
        q = pinocchio.neutral(model)
        for name in model.names[1:]:
            joint = model.joints[model.getJointId(name)]
            angle = value(name, values)
            if joint.nq == 2:
                q[joint.idx_q], q[joint.idx_q + 1] = np.cos(angle), np.sin(angle)
            else:
                q[joint.idx_q] = angle
        pinocchio.framesForwardKinematics(model, data, q)
        links = {}
        for link in robot.findall("link"):
            pose = data.oMf[model.getFrameId(link.get("name"), pinocchio.FrameType.BODY)]
            links[link.get("name")] = [*pose.rotation.flatten().tolist(), *pose.translation.tolist()]
        samples.append({"configuration": [values[name] for name in moving], "links": links})
    return {"file": path.name, "joints": moving, "samples": samples}


def main() -> None:
    robots = [golden(ROBOTS / "panda_spherized.urdf", 1), golden(ROBOTS / "all_kinds.urdf", 2)]
    document = {"pinocchio": pinocchio.__version__, "robots": robots}
    (ROOT / "golden" / "kinematics.json").write_text(json.dumps(document) + "\n")


if __name__ == "__main__":
    main()
