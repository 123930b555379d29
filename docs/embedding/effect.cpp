// An effect with CHAI3D's signature, any number of tools: effect ASSET.palp.
// Vector and base class stand for chai3d::cVector3d and chai3d::cGenericEffect, so that this
// compiles without the SDK; in a CHAI3D project delete them and derive from the real ones.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "palpate.h"

struct Vector3d {  // chai3d::cVector3d
  double x = 0, y = 0, z = 0;
};
struct GenericEffect {  // chai3d::cGenericEffect
  virtual ~GenericEffect() = default;
  virtual bool computeForce(const Vector3d& toolPos, const Vector3d& toolVel,
                            const unsigned int& toolID, Vector3d& force) = 0;
};

/// A Palpate body as an effect. Positions are the centres of balls in the body's frame.
class PalpateEffect final : public GenericEffect {
 public:
  static constexpr unsigned kMaxTools = 16;  // no allocation in the haptic thread

  /// The asset's bytes must outlive the effect, at a multiple of 64.
  PalpateEffect(const void* bytes, std::uint64_t size, double tool_radius_m) noexcept
      : status_(palpate_open(&asset_, bytes, size)) {
    const palpate_tool ball = palpate_ball(tool_radius_m);
    for (palpate_contact& contact : contacts_)
      if (status_ == PALPATE_OK) status_ = palpate_start(&contact, &ball);
  }

  palpate_status status() const noexcept { return status_; }

  /// True when the effect acts on the tool. force: on the tool [N].
  bool computeForce(const Vector3d& toolPos, const Vector3d&, const unsigned int& toolID,
                    Vector3d& force) override {
    force = {};
    if (status_ != PALPATE_OK || toolID >= kMaxTools) return false;
    const palpate_input in = palpate_input_at(toolPos.x, toolPos.y, toolPos.z);
    palpate_output out;
    palpate_tick(&asset_, &contacts_[toolID], &in, &out);
    force = {out.force_on_tool_N[0], out.force_on_tool_N[1], out.force_on_tool_N[2]};
    return out.state != PALPATE_AIR;
  }

 private:
  palpate_asset asset_;
  std::array<palpate_contact, kMaxTools> contacts_;
  palpate_status status_;
};

int main(int argc, char** argv) {
  std::FILE* file = argc == 2 ? std::fopen(argv[1], "rb") : nullptr;
  if (file == nullptr) return std::fprintf(stderr, "usage: effect ASSET.palp\n"), 2;
  std::fseek(file, 0, SEEK_END);
  const auto size = static_cast<std::size_t>(std::ftell(file));
  std::rewind(file);
  void* bytes = std::aligned_alloc(64, (size + 63) / 64 * 64);
  if (std::fread(bytes, 1, size, file) != size) return 1;
  std::fclose(file);
  PalpateEffect effect(bytes, size, 0.004);
  if (effect.status() != PALPATE_OK) return std::puts(palpate_sentence(effect.status())), 1;
  Vector3d force[2];
  unsigned touching = 0;
  for (int tick = 0; tick < 300; ++tick)  // two tools, pressing from above and from the side
    for (unsigned tool = 0; tool < 2; ++tool) {
      const double reach = 0.06 - 1e-4 * tick;
      const Vector3d at =
          tool == 0 ? Vector3d{0.0003, 0.0002, reach} : Vector3d{reach, 0.0002, 0.0003};
      touching += effect.computeForce(at, {}, tool, force[tool]) ? 1u : 0u;
    }
  std::printf("%u contacts, %.3f N up and %.3f N aside\n", touching, force[0].z, force[1].x);
  std::free(bytes);
  return force[0].z > 0 && force[1].x > 0 ? 0 : 1;
}
