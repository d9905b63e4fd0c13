"""Loads a model into MuJoCo, steps it, and prints its final state as JSON.

python3 mujoco_steps.py MODEL.xml STEPS [release]

`release` switches all welds between fragments off before the first step.
"""

import json
import sys

import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
if "release" in sys.argv[3:]:
    data.eq_active[:] = 0
mujoco.mj_forward(model, data)
begin = data.xipos.copy()
finite = True
for _ in range(int(sys.argv[2])):
    mujoco.mj_step(model, data)
    finite = finite and bool(np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all())
mujoco.mj_forward(model, data)
moved = np.linalg.norm(data.xipos - begin, axis=1)
# Free joints have seven coordinates each. `apart` is the change of the distance between neighbors, which does not depend on the object's
# own motion.
welds = [k for k in range(model.neq) if model.eq_type[k] == mujoco.mjtEq.mjEQ_WELD]
pairs = [(model.eq_obj1id[k], model.eq_obj2id[k]) for k in welds]
apart = [abs(np.linalg.norm(data.xipos[a] - data.xipos[b]) - np.linalg.norm(begin[a] - begin[b])) for a, b in pairs if a and b]
numeric = {mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_NUMERIC, k): int(model.numeric_size[k]) for k in range(model.nnumeric)}
print(json.dumps({
    "version": mujoco.__version__,
    "bodies": model.nbody - 1,
    "welds": len(welds),
    "excludes": model.nexclude,
    "meshes": model.nmesh,
    "numerics": numeric,
    "mass_kg": float(model.body_mass[1:].sum()),
    "masses_kg": model.body_mass[1:].tolist(),
    "inertias_kg_m2": model.body_inertia[1:].tolist(),
    "size_m": float(np.ptp(begin[1:], axis=0).max()) if model.nbody > 1 else 0.0,
    "lowest_m": float(data.xipos[1:, 2].min()),
    "floor_m": float(model.geom_pos[0][2]),
    "finite": finite,
    "warnings": [int(warning.number) for warning in data.warning],
    "moved_max_m": float(moved[1:].max()),
    "apart_max_m": float(max(apart, default=0.0)),
}))
