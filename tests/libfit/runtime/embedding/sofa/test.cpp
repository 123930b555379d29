// The SOFA component against stubs and the real engine: embedding_sofa ASSET.palp.
#include <atomic>
#include <cstdio>
#include <thread>

#include "docs/embedding/sofa/PalpateForceFeedback.h"

namespace {

int failures = 0;

void expect(bool holds, const char* claim) {
  if (holds) return;
  std::printf("does not hold: %s\n", claim);
  ++failures;
}

struct Component : PalpateForceFeedback {
  Component(const char* asset, double radius_m, double metres) {
    d_asset.setValue(asset);
    d_radius.setValue(radius_m);
    d_metres.setValue(metres);
    init();
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: embedding_sofa ASSET.palp\n"), 2;
  Component none("nowhere.palp", 0, 1);
  SReal f[3] = {1, 1, 1};
  none.computeForce(0, 0, 0, 0, 0, 0, 1, f[0], f[1], f[2]);
  expect(none.status() == PALPATE_BYTES_MISSING && f[0] == 0 && f[2] == 0,
         "a missing file is said, and has no force");

  std::vector<char> bytes(1 << 24);
  std::FILE* file = std::fopen(argv[1], "rb");
  const std::size_t size = file ? std::fread(bytes.data(), 1, bytes.size(), file) : 0;
  palpate_asset asset;
  expect(palpate_open(&asset, bytes.data(), size) == PALPATE_OK, "the asset opens");
  palpate_info info;
  palpate_describe(&asset, &info);
  palpate_contact plain;
  const palpate_tool ball = palpate_ball(info.probe_radius_m);
  palpate_start(&plain, &ball);

  // The scene is in millimetres. The simulation thread reads the surface while the haptic one
  // ticks.
  Component body(argv[1], info.probe_radius_m, 0.001);
  std::atomic<bool> is_over{false};
  float moved_m = 0;
  std::thread simulation([&] {
    std::vector<float> displacement_m;
    for (bool is_last = false; !is_last;) {
      is_last = is_over.load();  // before it reads, so that the deepest tick is seen once
      if (body.deform(displacement_m))
        for (const float m : displacement_m) moved_m = std::max(moved_m, m < 0 ? -m : m);
    }
  });
  bool is_equal = true;
  double largest_N = 0;
  for (int tick = 0; tick < 4000; ++tick) {
    const double at_mm[3] = {500 * (info.box_min_m[0] + info.box_max_m[0]),
                             500 * (info.box_min_m[1] + info.box_max_m[1]),
                             1000 * (info.box_max_m[2] + info.probe_radius_m) + 1 - 1e-3 * tick};
    const palpate_input in =
        palpate_input_at(at_mm[0] * 0.001, at_mm[1] * 0.001, at_mm[2] * 0.001, 0.001);
    palpate_output out;
    palpate_tick(&asset, &plain, 1, &in, &out);
    PalpateForceFeedback::Solid::SpatialVector wrench;
    body.computeWrench({{at_mm[0], at_mm[1], at_mm[2]}, {0, 0, 0, 1}}, {}, wrench);
    for (int k = 0; k < 3; ++k)
      is_equal = is_equal && wrench.getForce()[k] == out.force_on_tool_N[k];
    largest_N = std::max(largest_N, wrench.getForce()[2]);
  }
  is_over = true;
  simulation.join();
  expect(body.status() == PALPATE_OK && is_equal && largest_N > 0.01,
         "forces are the bits of the C engine");
  expect(moved_m > 1e-5f || !info.has_shape, "the simulation thread sees the dent");
  body.d_activate.setValue(false);
  body.computeForce(0, 0, 0, 0, 0, 0, 1, f[0], f[1], f[2]);
  expect(f[0] == 0 && f[1] == 0 && f[2] == 0, "one that is not active has no force");
  std::printf("largest force %.3f N, dent %.2f mm\n", largest_N, 1e3 * moved_m);
  return failures;
}
