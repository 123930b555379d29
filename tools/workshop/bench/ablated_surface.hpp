#pragma once

// The engine's law with an interpolation switched off: what the paper's clicks come from. For
// benchmarks and references only; the shipped engine has no such switch.

#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// Parts of the engine's interpolation; all true is the engine itself.
struct Ablation {
  bool blends_normals = true;  ///< else the facet's own normal
  bool blends_curves = true;   ///< else the mean curve of the facet's corners, all over it
};

template <class S>
runtime::MeshSpot<S> ablated(runtime::MeshSpot<S> spot, const Ablation& ablation,
                             const runtime::Vec3d& facet_normal) noexcept {
  if (!ablation.blends_normals) spot.normal = runtime::widened<S>(facet_normal);
  if (!ablation.blends_curves)
    for (S& n : spot.n) n = S(1.0 / 3);
  return spot;
}

/// A Path of slide.hpp over another one's spots.
struct AblatedPath {
  runtime::MeshPath<double, false> whole;
  Ablation ablation;
  runtime::Vec3d facet_normal;

  double end() const noexcept { return whole.end(); }
  bool is_blocked() const noexcept { return whole.is_blocked(); }
  bool is_straight() const noexcept { return whole.is_straight(); }
  const AblatedPath& plain() const noexcept { return *this; }
  template <class S>
  runtime::MeshSpot<S> at(const S& s) const noexcept {
    return ablated(whole.at(s), ablation, facet_normal);
  }
};

/// A Surface of slide.hpp.
class AblatedSurface {
 public:
  AblatedSurface(const runtime::AssetView& asset, int triangle, const double n[3],
                 const Ablation& ablation) noexcept
      : asset_(asset), whole_(corners_, asset, triangle, n, arm_), ablation_(ablation) {}

  int triangle() const noexcept { return whole_.triangle(); }
  double weight(int k) const noexcept { return whole_.weight(k); }
  runtime::MeshSpot<double> standing() const noexcept {
    return ablated(whole_.standing(), ablation_, facet_normal());
  }
  AblatedPath aim(const runtime::MeshSpot<double>& spot, const runtime::Vec3d& lateral) noexcept {
    return {whole_.aim(spot, lateral), ablation_, facet_normal()};
  }
  bool is_spent() const noexcept { return whole_.is_spent(); }
  void move(const AblatedPath& path, double s) noexcept { whole_.move(path.whole, s); }

 private:
  runtime::Vec3d facet_normal() const noexcept {
    return runtime::normalized(asset_.area_vector(whole_.triangle())) * -1.0;
  }

  const runtime::AssetView& asset_;
  runtime::Arm arm_;
  runtime::Corners corners_;
  runtime::MeshSurface<double, false> whole_;
  Ablation ablation_;
};

/// A tip that follows the ablated law: touch() without guard, slip budget, statuses and borders.
class AblatedTip {
 public:
  AblatedTip(const runtime::AssetView& asset, const Ablation& ablation) noexcept
      : asset_(asset), ablation_(ablation) {}

  int triangle() const noexcept { return contact_.triangle; }

  /// Force on the body at a tip [m] in body coordinates; zero in the air.
  runtime::Vec3d tick(const double tip_m[3]) noexcept {
    using namespace runtime;
    const Vec3d x = make_vec3<double>(tip_m) - make_vec3<double>(asset_.origin_m);
    const Vec3d before = contact_.has_tip ? make_vec3<double>(contact_.tip_m) : x;
    contact_.has_tip = true;
    put(x, contact_.tip_m);
    if (contact_.triangle < 0) find_contact(asset_, contact_, before, x);
    if (contact_.triangle < 0) return {0, 0, 0};
    AblatedSurface surface(asset_, contact_.triangle, contact_.weight, ablation_);
    return with_family(asset_.curves, [&](auto f) noexcept {
      using F = decltype(f);
      auto memory = F::template load<double>(contact_.memory);
      const auto step = law_step<F>(asset_.curves, x, Decay(), surface, memory);
      F::save(memory, contact_.memory);
      contact_.triangle = surface.triangle();
      for (int k = 0; k < 3; ++k) contact_.weight[k] = surface.weight(k);
      if (!(step.kinematics.d.normal_m > 0)) release(contact_);
      return step.answer.force_N;
    });
  }

 private:
  const runtime::AssetView& asset_;
  Ablation ablation_;
  runtime::Contact contact_;
};

}  // namespace palpate::tools
