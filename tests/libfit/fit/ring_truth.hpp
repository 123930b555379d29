// A point whose rings are known.
#pragma once

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {

inline constexpr double kDepth_m = 0.008;

struct RingTruth {
  CurveBasis basis{3, {0, 0.004, kDepth_m}};
  std::vector<std::vector<double>> control;

  RingTruth(const Vec3& inward, const Mat3& gradient, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> draw(0.8, 1.2);
    control.push_back({0});  // rises ever faster, so no ring is cut
    for (int j = 1; j < basis.size(); ++j)
      control[0].push_back(control[0].back() + 0.06 * j * draw(random));
    control.push_back({0.7 * draw(random)});
    control.push_back({0.3 * draw(random)});
    control.push_back({16 * draw(random)});
    control.push_back({0});  // no press spreads them
    const auto tangents = fit::tangents_of(inward);
    for (const double unit : {800.0, 3e4}) {
      const Vec3 side =
          unit * ((draw(random) - 1) * tangents[0] + (draw(random) - 1) * tangents[1]);
      control.push_back({side[0], side[1], side[2]});
    }
    constexpr int kAt[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    control.emplace_back();
    for (const auto& at : kAt) control.back().push_back(-gradient(at[0], at[1]));
    runtime::offset_curvature(control.back().data(),
                              -runtime::kCurvatureDepth * kDepth_m);  // (M15c)
    control.emplace_back(6, 0.0);                                     // it does not sway
  }
  fit::Bases bases() const {
    std::vector<CurveBasis> all(parts_of(CurveFamily::rings).size());
    all[0] = basis;
    return fit::Bases(all, CurveFamily::rings);
  }
  std::vector<Vec3> forces(const Vec3& inward, const Mat3& gradient,
                           const std::vector<Vec3>& rows) const {
    const fit::Bases all = bases();
    std::vector<runtime::Vec3d> force(rows.size());
    runtime::replay_drag<double>(all.views, fit::pointers_to<double>(control),
                                 fit::quadric_of(inward, gradient), rows.front().data(),
                                 static_cast<int>(rows.size()), force.data());
    std::vector<Vec3> out;
    for (const auto& f : force) out.emplace_back(f.x, f.y, f.z);
    return out;
  }
};

}  // namespace palpate::test
