// A ball on a flex of MuJoCo, a tick a line: the model as JSON on the first line, then "start x y z"
// or "x y z" [m] of the ball's centre on each. Answers each with "= fx fy fz microseconds", the force
// on the body [N] and the CPU of the step; the first with its degrees of freedom and bytes.
import { readSync } from "node:fs";
import load from "@mujoco/mujoco";

let kept = "";
const chunk = Buffer.alloc(1 << 16);
function line() {
  for (;;) {
    const end = kept.indexOf("\n");
    if (end >= 0) {
      const out = kept.slice(0, end);
      kept = kept.slice(end + 1);
      return out;
    }
    const got = readSync(0, chunk);
    if (got === 0) process.exit(0);
    kept += chunk.toString("utf8", 0, got);
  }
}

const mujoco = await load();
const m = JSON.parse(line());
const xml = `<mujoco><option timestep="${m.step_s}" gravity="0 0 0" integrator="discrete" solver="${m.solver}"
    iterations="${m.iterations}" tolerance="${m.tolerance}" cone="elliptic"/>
  <size memory="400M"/>
  <worldbody>
    <body name="ball" mocap="true" pos="${m.outside}"><geom type="sphere" size="${m.radius_m}" condim="3"
      friction="${m.friction} 0 0" priority="1" solref="${m.solref}" solimp="${m.solimp}" margin="0"/></body>
    <flexcomp name="body" type="direct" dim="3" radius="${m.skin_m}" mass="${m.mass_kg}"
      point="${m.points.join(" ")}" element="${m.elements.join(" ")}">
      <elasticity young="${m.young_Pa}" poisson="${m.poisson}" damping="${m.damping_s}"/>
      <contact selfcollide="none" internal="false" condim="3"/>
      <pin id="${m.held.join(" ")}"/>
    </flexcomp>
  </worldbody></mujoco>`;
const model = mujoco.MjModel.from_xml_string(xml);
const data = new mujoco.MjData(model);

function answer(force, microseconds) {
  process.stdout.write(`= ${force.join(" ")} ${microseconds}\n`);
}

answer([model.nv, 0, 0], Number(model.nbuffer) + Number(data.nbuffer));
for (;;) {
  const words = line().split(" ");
  if (words[0] === "start") {
    words.shift();
    mujoco.mj_resetData(model, data);
    data.mocap_pos.set(words.map(Number));
    mujoco.mj_forward(model, data);
    answer([0, 0, 0], 0);
    continue;
  }
  data.mocap_pos.set(words.map(Number));
  const began = process.cpuUsage();
  mujoco.mj_step(model, data);
  const took = process.cpuUsage(began);
  // All degrees of freedom are vertices along x, y and z; the ball alone constrains them.
  const push = data.qfrc_constraint;
  const force = [0, 0, 0];
  for (let i = 0; i < push.length; ++i) force[i % 3] += push[i];
  answer(force, took.user + took.system);
}
