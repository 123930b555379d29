// A body whose lateral stiffness depends on the direction: the anisotropic families.

#include <gtest/gtest.h>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kRange_m = 0.01;
constexpr double kSize = 0.5;  // 1.5 times as stiff along the fibres, half as stiff across

// Fibres along x, turned by 0.3 rad; 400 N/m down, 300 N/m aside on average.
const Vec3 kAlong(std::cos(0.3), std::sin(0.3), 0), kAcross(-std::sin(0.3), std::cos(0.3), 0);
Model fibrous_plate(double mu, CurveFamily family = CurveFamily::anisotropic) {
  Model model = plate_model(0.1, 20, uniform(400, 300, mu));
  make_anisotropic(model, kSize, [](const Vec3&) { return kAlong; });
  model.curves.is_coupled = is_coupled(family);
  if (!leans(family)) return model;
  model.curves.lean_basis = {2, {0, kRange_m}};
  model.curves.lean = Controls::Zero(model.surface.vertices.rows(), 9);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    model.curves.lean(v, 6) = 0.003 * (1 + 6 * model.surface.vertices(v, 0));
  return model;
}

TEST(anisotropic, a_line_is_a_stiffness_tensor) {
  const Loaded plate = load(fibrous_plate(1e6));
  Tool tool(plate.asset);
  const double depth_m = 0.004;
  tool.go({0, 0.001, 0.001}, {0, 0.001, -depth_m}, 1e-4);
  for (const double angle : {0.0, 0.3, 1.0, 2.0, 4.4}) {
    const Vec3 aside = 0.0008 * Vec3(std::cos(angle), std::sin(angle), 0);
    const Vec3 force = tool.tick(Vec3(0, 0.001, -depth_m) + aside);  // of the tool on the body
    EXPECT_NEAR(force.dot(kAlong), 300 * (1 + kSize) * aside.dot(kAlong), 1e-6) << angle;
    EXPECT_NEAR(force.dot(kAcross), 300 * (1 - kSize) * aside.dot(kAcross), 1e-6) << angle;
    EXPECT_NEAR(-force[2], 400 * depth_m, 1e-6) << angle;
    EXPECT_NEAR(tool.out.lateral_m, 0.0008, 1e-12) << "a length, not the metric's";
  }
}

TEST(anisotropic, force_is_the_gradient_of_the_stored_energy) {
  for (const CurveFamilyName& row : kCurveFamilyNames) {
    if (!is_anisotropic(row.family)) continue;
    SCOPED_TRACE(row.name);
    const Loaded plate = load(fibrous_plate(1e6, row.family));
    Tool tool(plate.asset);
    expect_force_is_energy_gradient(tool, {0.011, 0.001, -0.005}, 14);
  }
}

TEST(anisotropic, slips_end_where_the_force_is_the_limit_and_lift_off_without_a_pop) {
  for (const CurveFamilyName& row : kCurveFamilyNames) {
    if (!is_anisotropic(row.family)) continue;
    SCOPED_TRACE(row.name);
    const Loaded plate = load(fibrous_plate(0.3, row.family));
    Tool tool(plate.asset);
    tool.go({-0.02, 0.001, 0.001}, {-0.02, 0.001, -0.005}, 5e-5);
    tool.go({-0.02, 0.001, -0.005}, {0.02, 0.006, -0.005}, 5e-5);
    EXPECT_EQ(tool.out.state, ContactState::slip);
    const double limit_N = 0.3 * 400 * tool.out.normal_m;
    const Vec3 force = tool.tick({0.02, 0.006, -0.005});
    EXPECT_NEAR(force.head<2>().norm(), limit_N, 1e-6 * limit_N);
    expect_lift_off_without_a_pop(tool, {0.02, 0.006, -0.005});
  }
}

// A ring of fibres about the axis and their tensors blended over each triangle: no frame is needed
// where they turn, and a contact that is dragged round creates no energy.
TEST(anisotropic, fibres_may_turn_from_vertex_to_vertex) {
  Model sphere = sphere_model(0.03, 12, uniform(400, 300, 0.4));
  make_anisotropic(sphere, kSize, [](const Vec3& x) { return Vec3(-x[1], x[0], 0.002); });
  const Loaded ball = load(sphere);
  Tool tool(ball.asset);
  const auto way = [](double t) {
    const double r = 0.03 - 0.003 * std::sin(std::min(t, 0.5 * M_PI));
    return Vec3(r * std::cos(0.7 * t), r * std::sin(0.7 * t), 0.004 * std::sin(3 * t));
  };
  tool.tick({0.031, 0, 0});
  double supplied_J = 0;
  Vec3 before = way(0), force = tool.tick(before);
  constexpr int kTicks = 36000;
  for (int i = 1; i <= kTicks; ++i) {
    const Vec3 x = way(9.0 * i / kTicks);
    const Vec3 next = tool.tick(x);
    ASSERT_EQ(tool.status, Status::ok);
    supplied_J += 0.5 * (next + force).dot(x - before);
    before = x, force = next;
  }
  EXPECT_EQ(tool.out.state, ContactState::slip);
  EXPECT_GT(tool.out.dissipated_J, 0);
  const double spent_J = tool.out.stored_J + tool.out.dissipated_J;
  EXPECT_NEAR(supplied_J, spent_J, 0.004 * spent_J) << "trapezoids";
}

TEST(anisotropic, a_tensor_of_zeros_brings_the_forces_of_the_separable_family) {
  Model with = fibrous_plate(0.3), without = with;
  with.curves.anisotropy.setZero();
  without.curves.anisotropy.resize(0, 0);
  const Loaded a = load(with), b = load(without);
  Tool tool_a(a.asset), tool_b(b.asset);
  for (int i = 0; i < 400; ++i) {
    const double t = 0.02 * i;
    const Vec3 x(0.01 * std::sin(t), 0.008 * std::sin(1.7 * t), -0.004 + 0.005 * std::cos(t));
    EXPECT_LT((tool_a.tick(x) - tool_b.tick(x)).norm(), 1e-12) << i;
  }
}

TEST(anisotropic, such_an_asset_is_version_4_and_bounds_its_tensors) {
  Loaded plate = load(fibrous_plate(0.3));
  runtime::Header header;
  std::memcpy(&header, plate.bytes.data(), sizeof header);
  EXPECT_EQ(header.version, runtime::kAnisotropicVersion);
  const auto status_of = [&](const runtime::Header& changed) {
    runtime::Header sealed = changed;
    std::memcpy(plate.bytes.data(), &sealed, sizeof sealed);
    sealed.checksum = runtime::asset_checksum(plate.bytes.data(), plate.bytes.size());
    std::memcpy(plate.bytes.data(), &sealed, sizeof sealed);
    Status status;
    Asset::open(plate.bytes.data(), plate.bytes.size(), &status);
    return status;
  };
  runtime::Header older = header;
  older.version = runtime::kCoupledVersion;
  EXPECT_EQ(status_of(older), Status::layout_wrong);
  const auto stride = static_cast<std::size_t>(runtime::controls_per_vertex(header));
  auto* control = reinterpret_cast<float*>(plate.bytes.data() + header.offset[runtime::kControls]);
  for (const float wrong : {0.95F, -0.95F, std::nanf("")}) {
    float& xx = control[30 * stride + stride - runtime::kTensorSize];
    const float was = xx;
    xx = wrong;
    EXPECT_EQ(status_of(header), Status::controls_wrong) << wrong;
    xx = was;
  }
  EXPECT_EQ(status_of(header), Status::ok);
  Model wide = fibrous_plate(0.3);
  wide.curves.anisotropy.row(5) *= 1.3;
  EXPECT_THROW(load(wide), std::exception);
}

}  // namespace
}  // namespace palpate::test
