#include "tools/workshop/bench/tick_work.hpp"

#include <cmath>
#include <cstdint>
#include <set>

namespace palpate::tools {
namespace {

Vec3 at(double depth_m, double angle, double z_m) {
  const double r = kCylinderRadius_m - depth_m;
  return {r * std::cos(angle), r * std::sin(angle), z_m};
}

Vec3 press(long tick) { return at(0.003 + 0.001 * std::sin(0.01 * double(tick)), 0.41, 0.0512); }
Vec3 stick(long tick) {
  const double t = 0.01 * double(tick);
  return at(0.003, 0.41 + 0.003 * std::sin(t), 0.0512 + 1e-4 * std::cos(t));
}
Vec3 slip(long tick) {
  return at(0.003, 0.41 + 50e-6 / 0.027 * double(tick),
            0.05 + 0.03 * std::sin(1e-3 * double(tick)));
}
Vec3 touch_air(long tick) {
  const double t = 1e-3 * double(tick);
  return at(-0.0006 + 0.0004 * std::sin(7 * t), 0.41 + 0.5 * std::sin(t),
            0.05 + 0.02 * std::sin(1.3 * t));
}

}  // namespace

const std::array<TickKind, kTickKinds> kTicksOfKind{
    {{"press", press}, {"stick", stick}, {"slip", slip}, {"touch", touch_air}}};

std::vector<const unsigned char*> lines_of_a_tick(const runtime::AssetView& asset,
                                                  const runtime::Contact& contact) {
  std::set<std::uintptr_t> lines;
  const auto need = [&](const void* from, std::size_t bytes) {
    const auto begin = reinterpret_cast<std::uintptr_t>(from);
    for (std::uintptr_t line = begin / 64; line <= (begin + bytes - 1) / 64; ++line)
      lines.insert(line);
  };
  need(asset.triangle + 3 * contact.triangle, 12);
  need(asset.max_depth_m + contact.triangle, 4);
  for (int k = 0; k < 3; ++k) {
    const std::ptrdiff_t v = asset.corner(contact.triangle, k);
    need(asset.vertex + 3 * v, 12);
    need(asset.normal + 3 * v, 12);
    need(asset.covered + v, 1);
    need(asset.record + v, 4);
    const float* controls = asset.node(static_cast<int>(v));
    const runtime::FamilyRow& family =
        runtime::row_of(static_cast<runtime::Family>(asset.curves.family));
    for (int part = 0; part < family.parts; ++part) {  // of a curve those alive at the depth
      const runtime::SplineView& view = asset.curves.view[part];
      const int count = view.pieces > 0 ? view.degree + 1 : family.part[part].count;
      need(controls + asset.control_offset[part] + view.pieces / 2 * family.part[part].width,
           4 * static_cast<std::size_t>(count * family.part[part].width));
    }
  }
  for (const runtime::SplineView& view : asset.curves.view) {
    if (view.pieces == 0) continue;
    const auto order = static_cast<std::size_t>(view.degree + 1);
    need(view.knots, 8 * static_cast<std::size_t>(view.pieces + 1));
    need(view.weights + static_cast<std::size_t>(view.pieces / 2) * order * order,
         8 * order * order);
  }
  std::vector<const unsigned char*> out;
  for (std::uintptr_t line : lines)
    out.push_back(reinterpret_cast<const unsigned char*>(line * 64));
  return out;
}

}  // namespace palpate::tools
