#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "libfem/contact/contact.hpp"
#include "tests/libfem/fields.hpp"

namespace palpate::fem {
namespace {

using Tangent = ContactInterface::Tangent;

constexpr unsigned kSeed = 90210;
constexpr double kRadius_m = 0.01, kYoung_Pa = 10e3, kDepth_m = 0.001, kFriction = 0.4,
                 kSlippery = 0.1;
constexpr int kCells = 18;
constexpr double kCell_m = 0.001;

/// A square sheet in z = 0, outward normal up, its middle at the origin.
struct Sheet {
  Points nodes;
  Faces faces;
  std::vector<char> is_held;
  std::vector<double> young_Pa;

  Sheet() {
    const int wide = 2 * kCells + 1;
    nodes.resize(wide * wide, 3);
    for (int j = 0; j < wide; ++j)
      for (int i = 0; i < wide; ++i)
        nodes.row(j * wide + i) << kCell_m * (i - kCells) / 2, kCell_m * (j - kCells) / 2, 0;
    faces.resize(2 * kCells * kCells, kFaceNodes);
    Eigen::Index f = 0;
    for (int j = 0; j < kCells; ++j)
      for (int i = 0; i < kCells; ++i) {
        const auto node = [&](int a, int b) { return (2 * j + b) * wide + 2 * i + a; };
        faces.row(f++) << node(0, 0), node(2, 0), node(2, 2), node(1, 0), node(2, 1), node(1, 1);
        faces.row(f++) << node(0, 0), node(2, 2), node(0, 2), node(1, 1), node(1, 2), node(0, 1);
      }
    is_held.assign(static_cast<std::size_t>(nodes.rows()), 0);
    young_Pa.assign(static_cast<std::size_t>(faces.rows()), kYoung_Pa);
  }
};

/// Rounding wide enough for differences, curvature never cut: the stiffness is then exact.
ContactSettings exact_settings() {
  ContactSettings settings;
  settings.rounding = 1e-2;
  settings.curvature = 1e9;
  return settings;
}

ProbePose pose_at(double along_m, double depth_m) {
  // Off the nodes, so that no quadrature point is special.
  return {Vec3(0.00013 + along_m, -0.00021 + along_m / 3, -depth_m), -Vec3::UnitZ()};
}

Points assembled_force(const Sheet& sheet, const ContactInterface& contact) {
  Points force = Points::Zero(sheet.nodes.rows(), 3);
  for (const FaceTerms& terms : contact.terms())
    for (int a = 0; a < kFaceNodes; ++a)
      for (int i = 0; i < 3; ++i) force(sheet.faces(terms.face, a), i) += terms.force[3 * a + i];
  return force;
}

Points stiffness_times(const Sheet& sheet, const ContactInterface& contact, const Points& d) {
  Points out = Points::Zero(sheet.nodes.rows(), 3);
  using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  for (const FaceTerms& terms : contact.terms())
    for (int a = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a; ++b) {
        const Block K(terms.stiffness + 9 * (a * (a + 1) / 2 + b));
        const int na = sheet.faces(terms.face, a), nb = sheet.faces(terms.face, b);
        out.row(na) += (K * d.row(nb).transpose()).transpose();
        if (a != b) out.row(nb) += (K * d.row(na).transpose()).transpose();
      }
  return out;
}

/// A sheet that the probe has pressed and is now moved along by `along_m`, friction limit held
/// there.
struct Pressed {
  Sheet sheet;
  ContactInterface contact;
  ProbePose pose;
  ContactHistory history;
  Points u;

  Pressed(double friction, double along_m, double rough_m, unsigned seed)
      : contact(sheet.nodes, sheet.faces, sheet.is_held, sheet.young_Pa,
                make_probe(sphere_spec(kRadius_m, friction), "test"), exact_settings()),
        pose(pose_at(along_m, kDepth_m)) {
    const Points rest = Points::Zero(sheet.nodes.rows(), 3);
    const ProbePose before = pose_at(0, 0.9 * kDepth_m);
    const ContactHistory touching = contact.untouched(pose_at(0, 0));
    contact.lag_friction_limit({rest, before, touching});
    history = contact.accepted({rest, before, touching});
    u = random_field(sheet.nodes.rows(), rough_m, seed);
    contact.lag_friction_limit({u, pose, history});
  }
};

struct Case {
  const char* name;
  double friction, along_m;
};
// A point slides once the spring has been stretched by friction times ten times its penetration.
constexpr Case kCases[] = {{"frictionless", 0, 1e-3},
                           {"sticking", 100, 1e-5},
                           {"partly_sliding", kFriction, 2e-3},
                           {"sliding", kSlippery, 3e-3}};

void PrintTo(const Case& param, std::ostream* out) { *out << param.name; }

class ContactTerms : public testing::TestWithParam<Case> {};

TEST_P(ContactTerms, force_is_the_derivative_of_energy_for_the_limit_held) {
  for (unsigned seed = kSeed; seed < kSeed + 4; ++seed) {
    Pressed at(GetParam().friction, GetParam().along_m, 5e-5, seed);
    const ContactTotals totals = at.contact.evaluate({at.u, at.pose, at.history});
    ASSERT_GT(totals.points, 20);
    const Points force = assembled_force(at.sheet, at.contact);
    const Points d = random_field(at.u.rows(), kRadius_m, seed + 100);
    const double exact = force.cwiseProduct(d).sum();
    double least = std::numeric_limits<double>::infinity();
    for (const double h : {1e-4, 1e-5, 1e-6})
      least = std::min(least, std::abs((at.contact.energy({at.u + h * d, at.pose, at.history}) -
                                        at.contact.energy({at.u - h * d, at.pose, at.history})) /
                                           (2 * h) -
                                       exact));
    EXPECT_LE(least, 1e-7 * force.norm() * d.norm()) << "seed " << seed;
  }
}

TEST_P(ContactTerms, stiffness_is_the_derivative_of_force_for_the_limit_held_and_coupled) {
  for (const bool is_coupled : {false, true})
    for (unsigned seed = kSeed; seed < kSeed + 4; ++seed) {
      Pressed at(GetParam().friction, GetParam().along_m, 5e-5, seed);
      const auto force_at = [&](const Points& u) {
        const ContactTrial trial{u, at.pose, at.history};
        at.contact.evaluate(trial, is_coupled ? Tangent::coupled : Tangent::lagged);
        return assembled_force(at.sheet, at.contact);
      };
      force_at(at.u);
      const Points d = random_field(at.u.rows(), kRadius_m, seed + 200);
      const Points exact = stiffness_times(at.sheet, at.contact, d);
      double least = std::numeric_limits<double>::infinity();
      for (const double h : {1e-5, 1e-6, 1e-7}) {
        const Points difference = force_at(at.u + h * d) - force_at(at.u - h * d);
        least = std::min(least, (difference / (2 * h) - exact).norm());
      }
      EXPECT_LE(least, 1e-5 * exact.norm()) << "seed " << seed;
    }
}

TEST_P(ContactTerms, coupled_forces_are_those_of_the_limit_lagged_at_the_same_place) {
  Pressed at(GetParam().friction, GetParam().along_m, 5e-5, kSeed);
  at.contact.evaluate({at.u, at.pose, at.history});
  const Points lagged = assembled_force(at.sheet, at.contact);
  at.contact.evaluate({at.u, at.pose, at.history}, Tangent::coupled);
  EXPECT_LE((assembled_force(at.sheet, at.contact) - lagged).norm(), 1e-12 * lagged.norm());
}

TEST_P(ContactTerms, totals_are_minus_the_nodal_forces_and_their_moment_about_the_tip) {
  Pressed at(GetParam().friction, GetParam().along_m, 5e-5, kSeed);
  const ContactTotals totals = at.contact.evaluate({at.u, at.pose, at.history});
  const Points force = assembled_force(at.sheet, at.contact);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (Eigen::Index n = 0; n < force.rows(); ++n) {
    const Vec3 f = -force.row(n), x = at.sheet.nodes.row(n) + at.u.row(n);
    sum += f;
    moment += (x - at.pose.tip).cross(f);
  }
  EXPECT_LE((totals.force_N - sum).norm(), 1e-12 * sum.norm());
  EXPECT_LE((totals.torque_Nm - moment).norm(), 1e-12 * kRadius_m * sum.norm());
  EXPECT_LT(totals.force_N.z(), 0);  // of the probe on the body
}

INSTANTIATE_TEST_SUITE_P(States, ContactTerms, testing::ValuesIn(kCases),
                         [](const auto& state) { return std::string(state.param.name); });

TEST(ContactInterface,
     a_sliding_probe_drags_with_coulombs_force_along_its_motion_and_a_resting_one_not) {
  Pressed slides(kSlippery, 3e-3, 0, kSeed);
  const Vec3 sliding = slides.contact.evaluate({slides.u, slides.pose, slides.history}).force_N;
  const Vec3 motion = Vec3(3, 1, 0).normalized();
  // Traction lies in tangent planes of the ball and pressure across them; they are inclined by up
  // to 26 degrees, so that both lose a few percent here, and not the same.
  const double ratio = sliding.dot(motion) / -sliding.z();
  EXPECT_GT(ratio, 0.97 * kSlippery);
  EXPECT_LT(ratio, 1.05 * kSlippery);
  Pressed rests(kFriction, 0, 0, kSeed);
  const Vec3 resting = rests.contact.evaluate({rests.u, rests.pose, rests.history}).force_N;
  EXPECT_LT(resting.head<2>().norm(), 0.01 * -resting.z());
}

TEST(ContactInterface, faces_that_are_held_or_look_away_or_are_not_reached_exert_none) {
  Sheet sheet;
  const Points rest = Points::Zero(sheet.nodes.rows(), 3);
  const Probe probe = make_probe(sphere_spec(kRadius_m, kFriction), "test");
  const auto points_in_contact = [&](const ProbePose& pose) {
    ContactInterface contact(sheet.nodes, sheet.faces, sheet.is_held, sheet.young_Pa, probe);
    return contact.evaluate({rest, pose, contact.untouched(pose_at(0, 0))}).points;
  };
  EXPECT_GT(points_in_contact(pose_at(0, kDepth_m)), 20);
  EXPECT_EQ(points_in_contact(pose_at(0, -1e-6)), 0) << "above the surface";
  sheet.is_held.assign(sheet.is_held.size(), 1);
  EXPECT_EQ(points_in_contact(pose_at(0, kDepth_m)), 0) << "held";
  sheet = Sheet();
  sheet.faces.col(1).swap(sheet.faces.col(2));
  sheet.faces.col(3).swap(sheet.faces.col(5));
  EXPECT_EQ(points_in_contact(pose_at(0, kDepth_m)), 0) << "far wall";
}

// Pressure k times penetration over a flat rigid surface: F = pi k (R - d) d^2.
TEST(ContactInterface, a_flat_rigid_surface_takes_the_force_of_the_closed_form) {
  const Sheet sheet;
  const ContactSettings settings;
  ContactInterface contact(sheet.nodes, sheet.faces, sheet.is_held, sheet.young_Pa,
                           make_probe(sphere_spec(kRadius_m, 0), "test"), settings);
  const ContactHistory history = contact.untouched(pose_at(0, 0));
  const ContactTotals totals =
      contact.evaluate({Points::Zero(sheet.nodes.rows(), 3), pose_at(0, kDepth_m), history});
  const double k = settings.stiffness * kYoung_Pa / kRadius_m;
  const double expected = M_PI * k * (kRadius_m - kDepth_m) * kDepth_m * kDepth_m;
  EXPECT_NEAR(-totals.force_N.z() / expected, 1, 0.01);
  EXPECT_LT(totals.force_N.head<2>().norm(), 0.005 * expected);
  EXPECT_NEAR(totals.greatest_penetration_m / kDepth_m, 1, 0.02);
  const double area = M_PI * kDepth_m * (2 * kRadius_m - kDepth_m);
  EXPECT_NEAR(totals.area_m2 / area, 1, 0.02);
}

// The surface then bears the pressure of its overlap without overlapping: twice the force where it
// is.
TEST(ContactInterface, an_updated_multiplier_counts_overlap_twice_where_it_still_is) {
  const Sheet sheet;
  ContactInterface contact(sheet.nodes, sheet.faces, sheet.is_held, sheet.young_Pa,
                           make_probe(sphere_spec(kRadius_m), "test"));
  const Points u = Points::Zero(sheet.nodes.rows(), 3);
  const ProbePose pose = pose_at(0, kDepth_m);
  const ContactHistory accepted = contact.accepted({u, pose, contact.untouched(pose_at(0, 0))});
  const ContactHistory again = contact.updated_multipliers(accepted);
  const Vec3 once = contact.evaluate({u, pose, accepted}).force_N;
  const ContactTotals twice = contact.evaluate({u, pose, again});
  EXPECT_LT((twice.force_N - 2 * once).norm(), 0.01 * once.norm());
  EXPECT_NEAR(twice.greatest_penetration_m, kDepth_m, 0.02 * kDepth_m) << "true overlap";
  // A ball that has backed off to touching still bears: k (d - r^2/R) where r^2 < R d, half the
  // force.
  const ContactTotals backed = contact.evaluate({u, pose_at(0, 0), again});
  EXPECT_NEAR(backed.force_N.z() / once.z(), 0.5, 0.05);
  EXPECT_LT(backed.greatest_penetration_m, 1e-6 * kDepth_m);
}

// What sticks goes on bearing the traction it had: of a pose it does not move from, the lateral
// force stays.
TEST(ContactInterface, a_stiffer_penalty_presses_harder_and_keeps_the_traction_of_what_sticks) {
  const Sheet sheet;
  ContactInterface contact(sheet.nodes, sheet.faces, sheet.is_held, sheet.young_Pa,
                           make_probe(sphere_spec(kRadius_m, 100), "test"));
  const Points u = Points::Zero(sheet.nodes.rows(), 3);
  const ProbePose pressed = pose_at(0, kDepth_m), dragged = pose_at(1e-5, kDepth_m);
  const ContactHistory first = contact.accepted({u, pressed, contact.untouched(pose_at(0, 0))});
  const ContactHistory sticks = contact.accepted({u, dragged, first});
  contact.lag_friction_limit({u, dragged, sticks});
  const Vec3 before = contact.evaluate({u, dragged, sticks}).force_N;
  contact.stiffen(2);
  contact.lag_friction_limit({u, dragged, sticks});
  const Vec3 after = contact.evaluate({u, dragged, sticks}).force_N;
  ASSERT_GT(std::abs(before.x()), 0);
  // Along x the pressures of a shifted ball nearly cancel, so what is left is friction.
  EXPECT_NEAR(after.x() / before.x(), 1, 0.05);
  EXPECT_NEAR(after.z() / before.z(), 2, 0.05);
}

}  // namespace
}  // namespace palpate::fem
