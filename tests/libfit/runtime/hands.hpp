#pragma once

#include <vector>

#include "libfit/runtime/series/tick.hpp"
#include "tests/libfit/runtime/models.hpp"

// Balls that touch one body together.
namespace palpate::test::testing_hands {

using runtime::BallTick;
using runtime::CouplingView;
using runtime::TogetherMemory;

inline constexpr double kBallRadius_m = 0.004;

/// Sums of a and b (M62) at one place, in equal parts of its scales from 3 mm on.
inline CouplingView coupling_of(double isotropic_m_N, double tangential_m_N = 0) {
  CouplingView out;
  out.length_m = 0.003;
  for (int k = 0; k < 3; ++k) {
    out.isotropic_m_N[k] = isotropic_m_N / 3;
    out.tangential_m_N[k] = tangential_m_N / 3;
  }
  return out;
}

/// Rings on a sphere of 30 mm or a plate; slope: of its stiffness along x, a metre.
inline Model rings_body(bool is_round, double friction, double slope = 0) {
  Model model = is_round ? sphere_model(0.03, 24, uniform(400, 300, 0.3))
                         : plate_model(0.08, 16, uniform(400, 300, 0.3));
  make_rings(model, friction, is_round ? 0.03 : 0, [&](const Vec3& x) { return 1 + slope * x[0]; });
  return model;
}

/// The same on a body that sways, more at +x.
inline Model swaying_body(bool is_round, double friction, double slope = 0) {
  Model model = rings_body(is_round, friction, slope);
  set_sway(model, [](const Vec3& x) {
    const double more = 1 + 5 * x[0];
    return Symmetric{0.012 * more, 0.02, 0.004, 0.003, -0.001 * more, 0.002};
  });
  return model;
}

/// The balls, each with a contact, and what they remember together.
struct Hands {
  Loaded loaded;
  runtime::AssetView asset;
  CouplingView feel;
  std::vector<Contact> contact;
  std::vector<BallTick> tool;
  TogetherMemory joint;

  Hands(const Model& model, const CouplingView& of, std::size_t count)
      : loaded(load(model)), asset(loaded.asset), feel(of), contact(count), tool(count) {
    asset.coupling = &feel;
  }
  Hands(const Hands&) = delete;

  void tick(const std::vector<Vec3>& centre) {
    for (std::size_t i = 0; i < tool.size(); ++i) {
      tool[i].contact = &contact[i];
      tool[i].radius_m = kBallRadius_m;
      tool[i].tool = static_cast<int>(i);
      Eigen::Map<Vec3>(tool[i].place_m) = centre[i];
    }
    touch_together(asset, joint, tool.data(), static_cast<int>(tool.size()));
  }
  void go(const std::vector<Vec3>& to, int ticks) {
    std::vector<Vec3> from, at = to;
    for (const BallTick& t : tool) from.push_back(Eigen::Map<const Vec3>(t.place_m));
    for (int k = 1; k <= ticks; ++k) {
      for (std::size_t i = 0; i < to.size(); ++i) at[i] = from[i] + (to[i] - from[i]) * k / ticks;
      tick(at);
    }
  }
  double stored_J() const {
    double sum = 0;
    for (const BallTick& t : tool) sum += t.out.stored_J;
    return sum;
  }
  Vec3 force(std::size_t i) const { return -Eigen::Map<const Vec3>(tool[i].out.force_on_tool_N); }

  /// The state after another tick, which is undone.
  template <class Read>
  auto after(const std::vector<Vec3>& centre, const Read& read) {
    const auto contacts = contact;
    const auto tools = tool;
    const TogetherMemory before = joint;
    tick(centre);
    const auto out = read();
    contact = contacts;
    tool = tools;
    joint = before;
    return out;
  }
};

/// Where three balls are that are `depth_m` deep.
inline std::vector<Vec3> places(bool is_round, double depth_m) {
  std::vector<Vec3> out;
  for (const Vec3& way : {Vec3(-0.5, 0.1, 1), Vec3(0.35, 0.12, 1), Vec3(0.05, -0.4, 1)}) {
    const Vec3 u = way.normalized();
    out.push_back(is_round ? Vec3((0.03 + kBallRadius_m - depth_m) * u)
                           : Vec3(0.03 * u.x(), 0.03 * u.y(), kBallRadius_m - depth_m));
  }
  return out;
}

}  // namespace palpate::test::testing_hands
