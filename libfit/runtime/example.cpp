// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
// Presses a tip 5 mm into an asset at its first measured vertex, drags it 10 mm sideways, prints
// forces.
//   g++ -std=c++17 -O2 -ffp-contract=off example.cpp -o example && ./example ../asset.palp
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "engine.hpp"
using namespace palpate::runtime;

int main(int argc, char** argv) {
  std::FILE* file = argc > 1 ? std::fopen(argv[1], "rb") : nullptr;
  if (!file) return std::puts("usage: example ASSET.palp"), 2;
  std::vector<char> data;
  for (char block[65536]; std::size_t n = std::fread(block, 1, sizeof block, file);)
    data.insert(data.end(), block, block + n);
  std::fclose(file);
  void* bytes = std::aligned_alloc(64, (data.size() + 63) / 64 * 64);  // a file map does as well
  std::memcpy(bytes, data.data(), data.size());
  Status status;
  const Asset asset = Asset::open(bytes, data.size(), &status);
  if (status != Status::ok) return std::puts(sentence(status)), 1;
  int v = 0;
  while (v + 1 < asset.vertices && asset.covered[v] != kMeasured) ++v;
  const Vec3d in = asset.normal_at(v),
              start = asset.vertex_at(v) + make_vec3<double>(asset.origin_m);
  const Vec3d side =
      normalized(std::fabs(in.z) < 0.9 ? Vec3d{in.y, -in.x, 0} : Vec3d{0, in.z, -in.y});
  Contact contact;
  Output out;
  for (int tick = 0; tick <= 600; ++tick) {  // 1 kHz: 25 mm/s down from 1 mm above, then sideways
    const double depth_m = tick < 240 ? tick * 25e-6 - 1e-3 : 5e-3,
                 along_m = tick < 240 ? 0 : (tick - 240) * 28e-6;
    const Vec3d x = start + in * depth_m + side * along_m;
    const double tip_m[3] = {x.x, x.y, x.z};
    status = touch(asset, contact, tip_m, out);
    if (tick % 20 == 0)
      std::printf("%3d ms  depth %6.3f mm  along %6.3f mm  force on tool %8.4f %8.4f %8.4f N  %s\n",
                  tick, depth_m * 1e3, along_m * 1e3, out.force_on_tool_N[0],
                  out.force_on_tool_N[1], out.force_on_tool_N[2],
                  out.state == ContactState::air     ? "air"
                  : out.state == ContactState::stick ? "stick"
                                                     : "slip");
  }
  std::free(bytes);
  return status == Status::ok ? 0 : 1;
}
