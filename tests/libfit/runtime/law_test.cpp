// The stick/slip law by itself, in double and with derivatives.

#include "libfit/runtime/law/slide.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/series/quadric_replay.hpp"
#include "tests/libfit/runtime/models.hpp"
#include "tests/support/from_touch.hpp"

namespace palpate::test {
namespace {

using runtime::Jet3;
using runtime::Vec3d;

// Three straight curves over [0, 1] m: slopes are the only controls.
struct StraightCurves {
  SplineTables tables = tabulate({1, {0, 1}});
  runtime::CurveViews views;
  StraightCurves() {
    for (auto& view : views.view)
      view = {1, 1, tables.knots.data(), tables.weights.data(), tables.integrals.data()};
  }
};

template <class T>
std::vector<runtime::Vec3<T>> replay(const std::array<T, 3>& slope, const runtime::Quadric& quadric,
                                     const std::vector<double>& deflection,
                                     int* slipped = nullptr) {
  const StraightCurves curves;
  const T normal[2] = {T(0), slope[0]}, lateral[2] = {T(0), slope[1]}, limit[2] = {T(0), slope[2]};
  const runtime::ControlPointers<T> controls{{normal, lateral, limit}};
  const int rows = static_cast<int>(deflection.size() / 3);
  std::vector<runtime::Vec3<T>> force(deflection.size() / 3);
  const int count =
      runtime::replay_drag(curves.views, controls, quadric, deflection.data(), rows, force.data());
  if (slipped) *slipped = count;
  return force;
}

std::vector<double> curved_drag() {  // press 4 mm deep, then a bent way that slips, then a lift
  std::vector<double> out;
  for (int i = 0; i <= 8; ++i) out.insert(out.end(), {0, 0, 0.0005 * i});
  for (int i = 1; i <= 20; ++i) out.insert(out.end(), {3e-4 * i, 1e-5 * i * i, 0.004 - 5e-5 * i});
  for (int i = 1; i <= 8; ++i) out.insert(out.end(), {0.006, 0.004, 0.003 - 4e-4 * i});
  return out;
}

// A fixed contact point of the reference cylinder in double: k d^2 / 10 mm is a spline exactly.
struct CylinderSpot {
  static constexpr double kRange_m = 0.03;
  Vec3d point, normal;
  double k, lateral;  // [N/m]
  double control(int curve, int j) const {
    if (curve == 0) return j == 2 ? k * kRange_m * kRange_m / 0.01 : 0;
    return j == 1 ? lateral * kRange_m : 0;
  }
};

TEST(law, forces_at_fixed_contacts_are_the_reference_cylinders) {
  const Surface surface = cylinder_surface();
  const SplineTables parabola = tabulate({2, {0, CylinderSpot::kRange_m}}),
                     line = tabulate({1, {0, CylinderSpot::kRange_m}});
  runtime::CurveViews views;
  views.view[0] = {2, 1, parabola.knots.data(), parabola.weights.data(), parabola.integrals.data()};
  views.view[1] = {1, 1, line.knots.data(), line.weights.data(), line.integrals.data()};
  std::ifstream file(PALPATE_REFERENCE "/fixed_contact.csv");
  std::string text;
  int rows = 0, touching = 0;
  while (std::getline(file, text)) {
    std::stringstream cells(text);
    std::vector<double> c;
    for (std::string cell; std::getline(cells, cell, ',');)
      c.push_back(std::strtod(cell.c_str(), nullptr));
    if (c.size() != 12 || text[0] == 't') continue;
    ++rows;
    CylinderSpot spot{{0, 0, 0}, {0, 0, 0}, 0, 0};
    for (int j = 0; j < 3; ++j) {
      const Vec3 x = surface.vertices.row(surface.triangles(static_cast<int>(c[0]), j));
      const double n = c[static_cast<std::size_t>(j) + 1], around = std::hypot(x[0], x[1]);
      spot.point = spot.point + Vec3d{x[0], x[1], x[2]} * n;
      spot.normal = spot.normal + Vec3d{-x[0] / around, -x[1] / around, 0} * n;
      spot.k += n * cylinder_normal_N_m(x);
      spot.lateral += n * cylinder_lateral_N_m(x);
    }
    spot.normal = runtime::normalized(spot.normal);
    const Vec3d x{c[4], c[5], c[6]};
    const auto d = runtime::Separable::deflection(spot, x, {0, 0, 0});
    EXPECT_NEAR(d.normal_m, c[7], 1e-15) << text;
    EXPECT_NEAR(d.lateral_m, c[8], 1e-12) << text;
    const Vec3d f = test::force_from_touch(views, spot, x);
    const double size = std::hypot(c[9], c[10], c[11]);
    touching += size > 0;
    EXPECT_NEAR(f.x, c[9], 1e-9 * size) << text;
    EXPECT_NEAR(f.y, c[10], 1e-9 * size) << text;
    EXPECT_NEAR(f.z, c[11], 1e-9 * size) << text;
  }
  EXPECT_EQ(rows, 60);
  EXPECT_GT(touching, 30);
}

// The same node in an asset and under the fitter: what the fit scored is what the engine replays.
TEST(law, the_fitters_replay_and_the_engine_agree_bit_for_bit_while_a_contact_stands) {
  const Loaded plate = load(plate_model(0.125, 16, uniform(400, 300, 0.4)));
  const Asset& asset = plate.asset;
  int node = -1;
  for (int v = 0; v < asset.vertices; ++v)
    if (asset.vertex[3 * v] == 0 && asset.vertex[3 * v + 1] == 0) node = v;
  ASSERT_GE(node, 0);
  ASSERT_EQ(asset.origin_m[0], 0);
  std::array<std::vector<double>, 3> control;  // the asset's floats, as doubles
  for (int curve = 0; curve < 3; ++curve)
    for (int j = 0; j < asset.curves.view[curve].size(); ++j)
      control[std::size_t(curve)].push_back(
          double(asset.node(node)[asset.control_offset[curve] + j]));
  const runtime::Quadric flat{{0, 0, -1}, {}};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(-1, 1);
  int sticking = 0, slipping = 0;
  for (int drag = 0; drag < 40; ++drag) {
    std::vector<double> deflection;
    const double depth = 0.001 + 0.003 * std::abs(share(random)), along = 0.003 * share(random),
                 across = 0.003 * share(random);
    for (int i = 1; i <= 20; ++i) deflection.insert(deflection.end(), {0, 0, -depth * i / 20});
    for (int i = 1; i <= 40; ++i)
      deflection.insert(deflection.end(), {along * i / 40, across * i / 40, -depth});
    std::vector<Vec3d> fitted(deflection.size() / 3);
    runtime::replay_drag<double>(asset.curves,
                                 {{control[0].data(), control[1].data(), control[2].data()}}, flat,
                                 deflection.data(), static_cast<int>(fitted.size()), fitted.data());
    Tool tool(asset);
    tool.tick({0, 0, 0.001});
    bool has_slipped = false;
    for (std::size_t i = 0; i < fitted.size(); ++i) {
      const Vec3 f = tool.tick(Vec3::Map(deflection.data() + 3 * i));
      has_slipped = has_slipped || tool.out.state == ContactState::slip;
      const Vec3d& expected = fitted[i];
      if (!has_slipped) {
        ++sticking;
        ASSERT_EQ(f, Vec3(expected.x, expected.y, expected.z)) << "seed 11, drag " << drag;
      } else {  // the engine's place has area coordinates, the fitter's metres: they round apart
        ++slipping;
        ASSERT_LT((f - Vec3(expected.x, expected.y, expected.z)).norm(), 1e-9)
            << "seed 11, drag " << drag;
      }
    }
  }
  EXPECT_GT(sticking, 800);
  EXPECT_GT(slipping, 400);
}

TEST(law, forces_of_a_flat_drag_are_those_of_the_closed_form) {
  // k_z 400, k_r 300, mu 0.25 on a plane: f^r = min(300 d, 0.25 * 400 * depth).
  std::vector<double> deflection;
  for (int i = 0; i <= 40; ++i) deflection.insert(deflection.end(), {2e-4 * i, 0, 0.004});
  int slipped = 0;
  const auto force = replay<double>({400, 300, 100}, {{0, 0, 1}, {}}, deflection, &slipped);
  for (int i = 0; i <= 40; ++i) {
    EXPECT_NEAR(force[static_cast<std::size_t>(i)].x, std::min(300 * 2e-4 * i, 0.4), 1e-12) << i;
    EXPECT_NEAR(force[static_cast<std::size_t>(i)].z, 1.6, 1e-14) << i;
  }
  EXPECT_EQ(slipped, 34);
}

TEST(law, a_frictionless_drag_on_a_sphere_is_radial) {
  const double radius = 0.05;
  const runtime::Quadric sphere{{0, 0, 1}, {-1 / radius, 0, 0, 0, -1 / radius, 0, 0, 0, 0}};
  const auto force =
      replay<double>({400, 300, 0}, sphere, {0, 0, 0.003, 0.001, 0, 0.003, 0.002, 0, 0.003});
  for (std::size_t i : {1U, 2U}) {
    const double x = 0.001 * static_cast<double>(i), down = radius - 0.003;
    const double distance = std::hypot(x, down);
    // The quadric's normal field turns as p / R: second order in p / R from the sphere's own.
    EXPECT_NEAR(force[i].x / force[i].z, -x / down, 5e-3 * x / down) << i;
    EXPECT_NEAR(std::hypot(force[i].x, force[i].z), 400 * (radius - distance), 2e-3 * 1.2) << i;
  }
}

TEST(law, derivatives_flow_through_slips_and_lifts) {
  const runtime::Quadric quadric{{0, 0, 1}, {-10, 2, 0, 2, -20, 0, 0, 0, 0}};
  const std::array<double, 3> slope{400, 300, 100};
  const std::vector<double> deflection = curved_drag();
  std::array<Jet3, 3> jets{Jet3(400), Jet3(300), Jet3(100)};
  for (std::size_t i = 0; i < 3; ++i) jets[i].v[i] = 1;
  int slipped = 0;
  const auto force = replay<Jet3>(jets, quadric, deflection, &slipped);
  EXPECT_GT(slipped, 15);
  const auto plain = replay<double>(slope, quadric, deflection);
  for (std::size_t row = 0; row < plain.size(); ++row) {
    EXPECT_NEAR(plain[row].x, force[row].x.a, 1e-12) << row;
    EXPECT_NEAR(plain[row].z, force[row].z.a, 1e-12) << row;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    auto up = slope, down = slope;
    up[i] += 1e-3;
    down[i] -= 1e-3;
    const auto plus = replay<double>(up, quadric, deflection),
               minus = replay<double>(down, quadric, deflection);
    for (std::size_t row = 0; row < force.size(); ++row) {
      EXPECT_NEAR(force[row].x.v[i], (plus[row].x - minus[row].x) / 2e-3, 1e-10) << row << ' ' << i;
      EXPECT_NEAR(force[row].y.v[i], (plus[row].y - minus[row].y) / 2e-3, 1e-10) << row << ' ' << i;
      EXPECT_NEAR(force[row].z.v[i], (plus[row].z - minus[row].z) / 2e-3, 1e-10) << row << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace palpate::test
