// Rings that relax (docs/method-body.md, section 24), on a plane on which nothing varies.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "libfit/runtime/series/quadric_replay.hpp"
#include "tests/libfit/runtime/flat_rings.hpp"

namespace palpate::runtime {
namespace {

RelaxationView two_branches() {
  RelaxationView out;
  out.branches = 2;
  out.share[0] = 0.5;
  out.share[1] = 0.8;
  out.time_s[0] = 0.05;
  out.time_s[1] = 0.6;
  out.fast = 2.3;
  return out;
}
struct Plane {
  Quadratic curve;
  Numbers numbers;
  CurveViews views = views_of(curve);
  Quadric quadric{{0, 0, -1}, {}};
  ControlPointers<double> controls{{curve.control.data()}};

  Plane() {
    views.relaxation = two_branches();
    for (int part = 1; part <= kSway; ++part) controls.part[part] = numbers.of(part);
  }
  // Forces on the body at (x, y, depth) at these times.
  std::vector<Vec3d> replay(const std::vector<Vec3d>& way, const std::vector<double>& time_s) {
    std::vector<double> rows;
    for (const Vec3d& p : way) rows.insert(rows.end(), {p.x, p.y, -p.z});
    std::vector<Vec3d> force(way.size());
    replay_drag<double>(views, controls, quadric,
                        {rows.data(), static_cast<int>(way.size()), time_s.data()}, nullptr,
                        force.data());
    return force;
  }
};

TEST(RingsRelaxing, decay_is_the_exponential) {
  EXPECT_EQ(decay(0), 1);
  EXPECT_EQ(decay(800), 0);
  for (double x = 1e-9; x < 690; x *= 1.013)
    EXPECT_NEAR(decay(x) / std::exp(-x), 1, 1e-15 * (2 + x)) << x;
}

// Lee and Radok (1960): F(t) = int psi(t - s) d f(d(s)), here of f = 12 d + 4500 d^2 at speed v.
TEST(RingsRelaxing, a_press_at_constant_speed_is_the_hereditary_integral) {
  Plane plane;
  constexpr double kDeep_m = 7e-3;
  for (const double speed_m_s : {0.7e-3, 7e-3, 70e-3}) {
    const double end_s = kDeep_m / speed_m_s;
    std::vector<Vec3d> way;
    std::vector<double> time_s;
    for (int i = 1; i <= 50; ++i) {
      way.push_back({0, 0, kDeep_m * i / 50});
      time_s.push_back(end_s * i / 50);
    }
    const auto force = plane.replay(way, time_s);
    for (std::size_t i = 4; i < way.size(); ++i) {
      const double t = time_s[i], v = speed_m_s;
      double exact_N = plane.curve.force(way[i].z);
      for (int k = 0; k < 2; ++k) {
        const double tau = plane.views.relaxation.time_s[k], e = std::exp(-t / tau);
        exact_N += plane.views.relaxation.share[k] *
                   (12 * v * tau * (1 - e) + 9000 * v * v * tau * (t - tau * (1 - e)));
      }
      EXPECT_NEAR(-force[i].z / exact_N, 1, 0.015) << speed_m_s << " m/s, row " << i;
    }
  }
}

TEST(RingsRelaxing, forces_are_of_second_order_in_the_tick) {
  Plane plane;
  const auto at_half_way = [&](int ticks) {
    QuadricContact<Rings, double> contact(plane.views, plane.quadric, plane.controls);
    const double dt_s = 0.1 / ticks;
    const Decay left = decay_over(plane.views.relaxation, 0.5 * dt_s);
    Vec3d force = contact.go_to(plane.views, {0, 0, -4.5e-3}, Decay());  // in no time
    for (int i = 1; i <= ticks; ++i)
      force = contact.go_to(plane.views, {0, 0, -(4.5e-3 + 1e-3 * i / ticks)}, left);
    return -force.z;
  };
  const double exact = at_half_way(4096);
  double before = 0;
  for (const int ticks : {16, 32, 64, 128}) {
    const double error = std::fabs(at_half_way(ticks) - exact);
    if (before > 0) {
      EXPECT_NEAR(before / error, 4, 0.5) << ticks << " ticks";
    }
    before = error;
  }
}

TEST(RingsRelaxing, slow_motion_is_the_law_without_time) {
  Plane plane;
  std::vector<Vec3d> way;
  std::vector<double> slow_s, none;
  for (int i = 1; i <= 40; ++i) way.push_back({0, 0, 6e-3 * i / 40});
  for (int i = 1; i <= 60; ++i) way.push_back({6e-3 * i / 60, 1e-3 * i / 60, 6e-3});
  for (int i = 1; i <= 30; ++i) way.push_back({6e-3 - 2e-3 * i / 30, 1e-3, 6e-3 - 3e-3 * i / 30});
  for (std::size_t i = 0; i < way.size(); ++i) slow_s.push_back(1e3 * double(i + 1));
  const auto relaxed = plane.replay(way, slow_s);
  plane.views.relaxation = {};
  const auto elastic = plane.replay(way, slow_s);
  for (std::size_t i = 0; i < way.size(); ++i)
    EXPECT_LT(size(relaxed[i] - elastic[i]), 0.01 * size(elastic[i])) << "row " << i;
}

TEST(RingsRelaxing, a_tool_that_retracts_faster_than_the_body_is_never_pulled) {
  Plane plane;
  for (const double up_s : {1e-3, 1e-2, 0.1, 1.0}) {
    std::vector<Vec3d> way;
    std::vector<double> time_s;
    for (int i = 1; i <= 100; ++i) {
      way.push_back({0, 0, 7e-3 * std::min(i, 50) / 50});
      time_s.push_back(i < 51 ? 0.05 * i : 2.5 + (i - 50) * 0.2);
    }
    for (int i = 1; i <= 70; ++i) {
      way.push_back({0, 0, 7e-3 * (1 - i / 70.0)});
      time_s.push_back(12.5 + up_s * i / 70);
    }
    const auto force = plane.replay(way, time_s);
    for (const Vec3d& f : force) EXPECT_GE(-f.z, -1e-12);
    // 2.3 springs are let go where one was pressed: ring by ring at 1 - 1/2.3 of its depth.
    if (up_s == 1e-3) {
      EXPECT_LT(-force[140].z, 0.02 * plane.curve.force(7e-3));
    }
  }
}

// Held until it is slow, then slid until the share s = r/(1 + r) of its material is new, r = v
// tau/l (M48a): slow motion, the drag of new material, and forces right after a step. The share u
// of h that has flowed falls by a slide as it rises by time: 1 - u = r 2 s/(1 + s) u.
TEST(RingsRelaxing, a_slide_meets_material_that_has_not_flowed) {
  constexpr double kDeep_m = 6e-3, kRadius_m = 9e-3;
  Plane plane;
  plane.views.relaxation.radius_m = kRadius_m;
  const RelaxationView& relaxation = plane.views.relaxation;
  const double length_m = std::sqrt(1.6 * kRadius_m * kDeep_m);
  for (const double speed_m_s : {1e-5, 3e-3, 3e-2, 0.3, 100.0}) {
    std::vector<Vec3d> way;
    std::vector<double> time_s;
    for (int i = 1; i <= 40; ++i) {
      way.push_back({0, 0, kDeep_m * i / 40});
      time_s.push_back(10.0 * i);
    }
    for (int i = 1; i <= 200; ++i) {
      way.push_back({0.5e-3 * i, 0, kDeep_m});
      time_s.push_back(400 + 0.5e-3 * i / speed_m_s);
    }
    const Vec3d force = plane.replay(way, time_s).back();
    double normal_N = plane.curve.force(kDeep_m), drag_N = 0;
    for (int k = 0; k < 2; ++k) {
      const double r = speed_m_s * relaxation.time_s[k] / length_m, s = r / (1 + r);
      const double u = 1 / (1 + 2 * r * s / (1 + s));
      normal_N += relaxation.share[k] * (1 - u) * plane.curve.force(kDeep_m);
      drag_N += relaxation.share[k] * s * u * (2 * (1 - u) / (1 + s) + u * (1 - s)) / length_m * 2 *
                plane.curve.energy(kDeep_m);
    }
    EXPECT_NEAR(-force.z, normal_N, 0.03 * normal_N) << speed_m_s;
    const double mu = plane.numbers.friction + plane.numbers.slope * kDeep_m;
    EXPECT_NEAR(force.x, mu * normal_N + drag_N, 0.05 * (mu * normal_N + drag_N)) << speed_m_s;
  }
}

template <class C>
void expect_gradient(const RelaxationView& relaxation, std::uint64_t seed) {
  const bool relaxes = relaxation.branches > 0;
  const double h = relaxes ? 1e-7 : 1e-6, tolerance = relaxes ? 2e-5 : 2e-6;
  const C curve;
  CurveViews views = views_of(curve);
  views.relaxation = relaxation;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto draw = [&](double scale) {
    const double x = unit(random), y = unit(random), z = unit(random);
    return Vec3d{x * scale, y * scale, z * scale};
  };
  for (int trial = 0; trial < 300; ++trial) {
    Numbers numbers;
    for (int k = 0; k < 3; ++k) {
      numbers.side2[k] = 900 * unit(random);
      numbers.side3[k] = 5e4 * unit(random);
    }
    if (!relaxes) numbers.spread = 30 * (1 + unit(random));
    for (double& kappa : numbers.curvature) kappa = 40 * unit(random);
    const FlatSpot<double> spot{draw(0.01), normalized(draw(1)), &curve, &numbers};
    double held[Rings::kMemory] = {};
    auto memory = Rings::load<double>(held, views.relaxation);
    for (int i = 0; i < kRings; ++i) memory.set(i, tangential(draw(2e-3), spot.normal));
    if (trial % 2 == 0) memory.set(0, {0, 0, 0});
    for (int i = 1; i < kRings && !relaxes; ++i) memory.out[i] = 1e-3 * unit(random);
    for (int k = 0; k < views.relaxation.branches; ++k)
      for (int i = 0; i < kRings; ++i) {
        memory.creep.flow[k][0][i] = 4e-3 * std::fabs(unit(random));
        const Vec3d w = tangential(draw(1e-3), spot.normal);
        memory.creep.flow[k][1][i] = w.x;
        memory.creep.flow[k][2][i] = w.y;
        memory.creep.flow[k][3][i] = w.z;
      }
    find_rests(views.relaxation, memory.creep);
    const Vec3d x = spot.point + spot.normal * (4.5e-3 + 4e-3 * unit(random)) + draw(2e-3);
    const auto answer = [&](const Vec3d& place) {
      const auto kinematics = Rings::kinematics(views, spot, place, memory);
      const auto& bed = Rings::bed(views, kinematics);
      return Rings::answer(views, bed, kinematics, Rings::stick(views, bed, kinematics, memory));
    };
    const auto kinematics = Rings::kinematics(views, spot, x, memory);
    if (kinematics.at.depth_m < 1e-5) continue;
    const Answer<double> here = answer(x);
    EXPECT_NEAR(Rings::stored_J(views, Rings::bed(views, kinematics), kinematics, memory),
                here.stored_J, 1e-15);
    const Vec3d slope{answer(x + Vec3d{h, 0, 0}).stored_J - answer(x - Vec3d{h, 0, 0}).stored_J,
                      answer(x + Vec3d{0, h, 0}).stored_J - answer(x - Vec3d{0, h, 0}).stored_J,
                      answer(x + Vec3d{0, 0, h}).stored_J - answer(x - Vec3d{0, 0, h}).stored_J};
    EXPECT_LT(size(slope * (0.5 / h) - here.force_N), tolerance * (1 + size(here.force_N)))
        << "seed " << seed << " trial " << trial;
    if (!relaxes) continue;
    // Without a side force dashpots only take.
    numbers = Numbers();
    const double before_J = answer(x).stored_J;
    const double dt_s = std::pow(10, 3 * unit(random));
    Rings::relax(views, Rings::kinematics(views, spot, x, memory),
                 decay_over(views.relaxation, dt_s), memory);
    EXPECT_LE(answer(x).stored_J, before_J * (1 + 1e-12)) << "seed " << seed << " trial " << trial;
  }
}
TEST(RingsRelaxing, force_is_the_gradient_of_the_energy_and_dashpots_take) {
  for (const RelaxationView& relaxation : {RelaxationView(), two_branches()}) {
    expect_gradient<Quadratic>(relaxation, 1);
    expect_gradient<Concave>(relaxation, 2);  // rings that are cut
  }
}

}  // namespace
}  // namespace palpate::runtime
