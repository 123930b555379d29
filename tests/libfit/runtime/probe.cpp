// Hashes the outputs of a winding path: equal on every compiler and level. probe ASSET TICKS
#include <cstdio>
#include <cstdlib>

#include "engine.hpp"
#include "series/quadric_replay.hpp"
using namespace palpate::runtime;

// The fitter's side of the law: drags over a quadric with the curves of one vertex after another.
static std::uint64_t hash_of_fitters_replay(const Asset& asset) {
  constexpr int kRows = 60, kMax = 512;
  const Quadric quadric{{0, 0, -1}, {-30, 2, 0, 2, -20, 0, 0, 0, 0}};
  double way[3 * kRows];
  for (int i = 0; i < kRows; ++i) {
    way[3 * i] = i < 20 ? 0 : 1e-4 * (i - 20);
    way[3 * i + 1] = i < 20 ? 0 : 3e-6 * (i - 20) * (i - 20);
    way[3 * i + 2] = i < 20 ? -1.5e-4 * i : -0.003 + 4e-5 * (i - 20);
  }
  std::uint64_t hash = 0;
  for (int v = 0; v < asset.vertices && asset.controls_per_vertex <= kMax; ++v) {
    double control[kMax];
    for (int j = 0; j < asset.controls_per_vertex; ++j) control[j] = double(asset.node(v)[j]);
    ControlPointers<double> controls{};
    for (int part = 0; part < kMaxParts; ++part)
      controls.part[part] = control + asset.control_offset[part];
    Vec3d force[kRows];
    hash += static_cast<std::uint64_t>(
        replay_drag<double>(asset.curves, controls, quadric, way, kRows, force));
    double numbers[3 * kRows];
    for (int i = 0; i < kRows; ++i) put(force[i], numbers + 3 * i);
    hash = hash * 31 + checksum(numbers, sizeof numbers);
  }
  return hash;
}

// The surface as it is shown under tip and ball.
static std::uint64_t hash_of_shape(const Asset& asset, const Contact& tip, const Contact& ball) {
  constexpr int kVertices = 64;
  float moved[2][3 * kVertices];
  std::uint64_t hash = 0;
  for (int v = 0; v < asset.vertices; v += kVertices) {
    const int count = v + kVertices < asset.vertices ? kVertices : asset.vertices - v;
    std::memset(moved, 0, sizeof moved);
    deform(asset, tip, 0, v, count, moved[0]);
    deform(asset, ball, 0.002, v, count, moved[1]);
    hash = hash * 31 + checksum(moved, sizeof moved);
  }
  return hash;
}

int main(int argc, char** argv) {
  std::FILE* file = argc > 1 ? std::fopen(argv[1], "rb") : nullptr;
  if (!file) return 2;
  alignas(64) static char bytes[1 << 24];
  const std::size_t size = std::fread(bytes, 1, sizeof bytes, file);
  std::fclose(file);
  Status status;
  const Asset asset = Asset::open(bytes, size, &status);
  if (status != Status::ok) return std::puts(sentence(status)), 1;
  const long ticks = argc > 2 ? std::atol(argv[2]) : 100000;
  Contact contact, ball_contact;
  Output out, ball;
  double tangent[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
  std::uint64_t hash = hash_of_fitters_replay(asset), random = 1;
  long touching = 0, slipping = 0;
  double tip[3] = {0.04, 0, 0}, goal[3] = {0, 0, 0.02};
  for (long tick = 0; tick < ticks; ++tick) {
    if (tick % 200 == 0)
      for (double& g : goal) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        g = (double(random >> 11) / 9007199254740992.0 - 0.5) * 0.06;
      }
    for (int k = 0; k < 3; ++k) tip[k] += (goal[k] - tip[k]) * 0.01;
    if (touch(asset, contact, tip, out) != Status::ok) return 1;
    touch_ball(asset, ball_contact, tip, 0.002, ball, tick % 8 == 0 ? tangent : nullptr);
    const double words[11] = {out.force_on_tool_N[0],
                              out.force_on_tool_N[1],
                              out.force_on_tool_N[2],
                              out.contact_m[0],
                              out.stored_J,
                              out.dissipated_J,
                              ball.force_on_tool_N[0],
                              ball.force_on_tool_N[1],
                              ball.force_on_tool_N[2],
                              tangent[0],
                              tangent[5]};
    hash = hash * 31 + checksum(words, sizeof words);
    if (asset.shape.points > 0 && tick % 64 == 0)
      hash = hash * 31 + hash_of_shape(asset, contact, ball_contact);
    touching += out.state != ContactState::air;
    slipping += out.state == ContactState::slip;
  }
  std::printf("%016llx after %ld ticks in contact, %ld slipping\n",
              static_cast<unsigned long long>(hash), touching, slipping);
  return touching > 1000 && slipping > 1000 ? 0 : 1;
}
