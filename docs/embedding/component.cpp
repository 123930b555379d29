// A component in the manner of Unreal, plain C++: component ASSET.palp.
// Unreal counts in centimetres on left-handed axes (x forward, y right, z up) and ticks with the
// frame; a force thread ticks much faster. Vector and Quat stand for FVector and FQuat.
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "palpate.h"

struct Vector {  // FVector [cm]
  double X = 0, Y = 0, Z = 0;
};
struct Quat {  // FQuat
  double X = 0, Y = 0, Z = 0, W = 1;
};
struct Transform {  // FTransform without scale
  Quat rotation;
  Vector translation;
};

/// Mirrors y: left-handed centimetres to right-handed metres, and back for forces.
palpate_pose to_pose(const Transform& t) noexcept {
  return {{0.01 * t.translation.X, -0.01 * t.translation.Y, 0.01 * t.translation.Z},
          {t.rotation.W, -t.rotation.X, t.rotation.Y, -t.rotation.Z}};
}
Vector to_force(const double newtons[3]) noexcept { return {newtons[0], -newtons[1], newtons[2]}; }

/// A soft body in the world. The game thread places it, the force thread asks for forces.
class PalpateComponent {
 public:
  /// BeginPlay: bytes at a multiple of 8 that outlive the component.
  bool begin_play(const void* bytes, std::uint64_t size, const palpate_tool& tool) noexcept {
    status_ = palpate_open(&asset_, bytes, size);
    if (status_ == PALPATE_OK) status_ = palpate_start(&contact_, &tool);
    return status_ == PALPATE_OK;
  }
  palpate_status status() const noexcept { return status_; }

  /// TickComponent, game thread, 60 Hz: where the body is now. Three poses, of which the writer
  /// owns one: neither thread waits for the other.
  void set_body(const Transform& world) noexcept {
    slot_[writing_] = world;
    writing_ = latest_.exchange(writing_ | kFresh) & 3;
  }

  /// Force thread, 1 kHz: force on the tool [N], in the world's left-handed axes.
  Vector compute_force(const Transform& tool, double dt_s) noexcept {
    if ((latest_.load() & kFresh) != 0) reading_ = latest_.exchange(reading_) & 3;
    palpate_input in = palpate_input_at(0, 0, 0, 0.001);
    in.tool = to_pose(tool);
    in.body = to_pose(slot_[reading_]);
    in.dt_s = dt_s;
    palpate_output out;
    palpate_tick(&asset_, &contact_, 1, &in, &out);
    return to_force(out.force_on_tool_N);
  }

 private:
  static constexpr int kFresh = 4;
  palpate_asset asset_{};
  palpate_contact contact_{};
  palpate_status status_ = PALPATE_ASSET_NOT_OPEN;
  Transform slot_[3];
  int writing_ = 0, reading_ = 1;
  std::atomic<int> latest_{2};
};

int main(int argc, char** argv) {
  std::FILE* file = argc == 2 ? std::fopen(argv[1], "rb") : nullptr;
  if (file == nullptr) return std::fprintf(stderr, "usage: component ASSET.palp\n"), 2;
  std::fseek(file, 0, SEEK_END);
  const auto size = static_cast<std::size_t>(std::ftell(file));
  std::rewind(file);
  void* bytes = std::malloc(size);
  if (std::fread(bytes, 1, size, file) != size) return 1;
  std::fclose(file);
  PalpateComponent body;
  if (!body.begin_play(bytes, size, palpate_ball(0.004)))
    return std::puts(palpate_sentence(body.status())), 1;
  const Transform home{{0, 0, 0.70710678118654752, 0.70710678118654752},
                       {100, 50, 20}};  // turned by 90 degrees
  body.set_body(home);
  Vector force;
  for (int tick = 0; tick < 300; ++tick) {
    Transform tool = home;
    tool.translation.Z +=
        6 - 0.01 * tick;  // from 60 mm above its middle, 10 mm/s... per tick 0.1 mm
    tool.translation.X += 0.03;
    if (tick % 16 == 0) body.set_body(home);
    force = body.compute_force(tool, 1e-3);
  }
  std::printf("force on the tool %.3f %.3f %.3f N\n", force.X, force.Y, force.Z);
  std::free(bytes);
  return force.Z > 0 ? 0 : 1;
}
