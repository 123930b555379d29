// The CHAI3D body against stubs and the real engine: embedding_chai3d ASSET.palp COUPLED.palp.
#include <algorithm>
#include <cstdio>
#include <cstring>

#include "docs/embedding/chai3d/cPalpateBody.h"

namespace {

int failures = 0;

void expect(bool holds, const char* claim) {
  if (holds) return;
  std::printf("does not hold: %s\n", claim);
  ++failures;
}

}  // namespace

// Two tools side by side, beside the same two of the C engine in one call.
void two_tools_feel_each_other(const char* file) {
  palpate_info info;
  {
    cPalpateBody body(file, palpate_tip());
    palpate_describe(&body.effect().asset(), &info);
  }
  const palpate_tool ball = palpate_ball(info.probe_radius_m);
  cPalpateBody body(file, ball);
  expect(info.couples && body.status() == PALPATE_OK,
         "the second asset's contacts feel each other");
  palpate_contact plain[2];
  for (palpate_contact& contact : plain) palpate_start(&contact, &ball);
  palpate_input in[2];
  palpate_output out[2];
  bool is_equal = true, has_touched = false;
  for (int tick = 0; tick < 400; ++tick) {
    chai3d::cVector3d force[2];
    for (int tool = 0; tool < 2; ++tool) {  // a tick each, as the haptic thread asks
      in[tool] =
          palpate_input_at(0.5 * (info.box_min_m[0] + info.box_max_m[0]) + 0.01 * tool,
                           0.5 * (info.box_min_m[1] + info.box_max_m[1]),
                           info.box_max_m[2] + info.probe_radius_m + 0.001 - 1e-5 * tick, 0.001);
      const double* at = in[tool].tool.position_m;
      const unsigned id = tool == 0 ? 7 : 3;
      body.m_effects[0]->computeForce({at[0], at[1], at[2]}, {}, id, force[tool]);
      palpate_tick(&body.effect().asset(), plain, tick == 0 ? tool + 1 : 2, in, out);
      const double felt[3] = {force[tool].x(), force[tool].y(), force[tool].z()};
      is_equal = is_equal && std::memcmp(felt, out[tool].force_on_tool_N, sizeof felt) == 0;
      has_touched = has_touched || out[tool].state != PALPATE_AIR;
    }
  }
  expect(is_equal && has_touched, "tools that feel each other have the bits of one call in C");
}

int main(int argc, char** argv) {
  if (argc != 3)
    return std::fprintf(stderr, "usage: embedding_chai3d ASSET.palp COUPLED.palp\n"), 2;
  const palpate_tool ball = palpate_ball(0.004);
  expect(cPalpateBody("nowhere.palp", ball).status() == PALPATE_BYTES_MISSING,
         "a missing file is said");
  cPalpateBody body(argv[1], ball);
  if (body.status() != PALPATE_OK) return std::puts(palpate_sentence(body.status())), 1;

  palpate_mesh mesh;
  palpate_info info;
  palpate_read_mesh(&body.effect().asset(), &mesh);
  palpate_describe(&body.effect().asset(), &info);
  expect(body.m_vertices->m_localPos.size() == static_cast<std::size_t>(mesh.vertices) &&
             body.triangles == static_cast<unsigned>(mesh.triangles),
         "the whole surface is there");

  // Two tools at once, from above and from the side, beside a plain contact for the first one.
  palpate_contact plain;
  palpate_start(&plain, &ball);
  const double middle[3] = {0.5 * (info.box_min_m[0] + info.box_max_m[0]) + 0.0003,
                            0.5 * (info.box_min_m[1] + info.box_max_m[1]) + 0.0002,
                            0.5 * (info.box_min_m[2] + info.box_max_m[2]) + 0.0003};
  bool is_equal = true, has_touched[2] = {};
  chai3d::cVector3d force[2];
  for (int tick = 0; tick < 150; ++tick) {
    const double above = info.box_max_m[2] + 0.008 - 1e-4 * tick;
    const double beside = info.box_max_m[0] + 0.008 - 1e-4 * tick;
    const chai3d::cVector3d at[2] = {{middle[0], middle[1], above}, {beside, middle[1], middle[2]}};
    for (unsigned tool = 0; tool < 2; ++tool)
      if (body.m_effects[0]->computeForce(at[tool], {}, tool, force[tool]))
        has_touched[tool] = true;
    const palpate_input in = palpate_input_at(middle[0], middle[1], above, 0.001);
    palpate_output out;
    palpate_tick(&body.effect().asset(), &plain, 1, &in, &out);
    const double felt[3] = {force[0].x(), force[0].y(), force[0].z()};
    is_equal = is_equal && std::memcmp(felt, out.force_on_tool_N, sizeof felt) == 0;
  }
  expect(is_equal, "the force has the bits of the C engine");
  expect(has_touched[0] && has_touched[1], "both tools touch");
  expect(force[0].z() > 0.1 && force[1].x() > 0.1, "both are pushed out");
  chai3d::cVector3d none(1, 1, 1);
  expect(!body.m_effects[0]->computeForce({}, {}, 16, none) && none.z() == 0,
         "a tool too many feels nothing");

  two_tools_feel_each_other(argv[2]);
  body.updateSurface();
  double down = 0, in = 0;
  for (int v = 0; v < mesh.vertices; ++v) {
    const chai3d::cVector3d& at = body.m_vertices->m_localPos[static_cast<std::size_t>(v)];
    down =
        std::min(down, at.z() - mesh.origin_m[2] - static_cast<double>(mesh.vertex_m[3 * v + 2]));
    in = std::min(in, at.x() - mesh.origin_m[0] - static_cast<double>(mesh.vertex_m[3 * v]));
  }
  expect(!info.has_shape || (down < -0.002 && in < -0.002),
         "the surface gives way under both tools");
  std::printf("%.3f N up, %.3f N aside, surface %.1f mm down, %.1f mm in\n", force[0].z(),
              force[1].x(), -1e3 * down, -1e3 * in);
  return failures;
}
