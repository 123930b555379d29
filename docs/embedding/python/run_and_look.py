"""From a scene in Python to an asset and its error: run_and_look.py MESH FOLDER [PICTURE.png]."""
import os
import sys

import palpate

mesh, folder = sys.argv[1:3]
scene = {
    "body": {"surface": mesh, "length_unit": "mm", "mesh_size": "20 mm",
             "fixed": [{"below": {"axis": "z", "at": "1 mm"}}]},
    "material": {"young": "10 kPa", "poisson": 0.4},
    "probe": {"radius": "8 mm", "friction": 0.3},
    "experiments": {"test_points": 4, "region": {"above": {"axis": "z", "at": "29 mm"}}, "depth": "4 mm",
                    "press_steps": 5, "drag_depths": ["3 mm"], "drag_distance": "5 mm", "drag_directions": 1,
                    "drag_steps": 9},
    "validate": {"points": 2, "causes": False},
}
error = palpate.run(scene, folder, jobs=1, quiet=True)["force_error"]
print(f"half of the forces are within {100 * error['median_rel']:.1f} %, "
      f"19 of 20 within {100 * error['p95_rel']:.1f} %")
for point, curves in palpate.curves(os.path.join(folder, "curves.h5")).items():
    normal = curves["normal"]
    print(f"{point}: {normal['value_N'][-1]:.3f} +- {normal['deviation_N'][-1]:.3f} N at "
          f"{1e3 * normal['at_m'][-1]:.1f} mm")
if len(sys.argv) > 3:
    palpate.plot_curve(normal, label=point).figure.savefig(sys.argv[3], dpi=100)
