#include "libfem/mesh/surface/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/support/error_of.hpp"

namespace palpate {
namespace {

constexpr double kRadius_m = 0.05;

// Contacts on a ball about the origin, evenly spread over a cap of it (1: all of it), with noise
// along the normal.
Contacts on_ball(int count, double cap, double noise_m, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_m);
  Contacts out{Points(count, 3), Points(count, 3), Eigen::VectorXd::Constant(count, noise_m)};
  for (int i = 0; i < count; ++i) {  // Fibonacci's lattice
    const double z = 1 - 2 * cap * (i + 0.5) / count, turn = i * 2.399963229728653;
    const Vec3 outward(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn),
                       z);
    out.position.row(i) = (kRadius_m + noise(random)) * outward;
    out.normal.row(i) = -outward;
  }
  return out;
}

// Of vertices between contacts; beyond them the surface is only a margin.
double largest_off_ball_m(const ContactSurface& made, const Contacts& contacts) {
  double largest_m = 0;
  for (const auto& vertex : made.surface.vertices.rowwise())
    if ((contacts.position.rowwise() - vertex).rowwise().norm().minCoeff() < 0.6 * made.spacing_m)
      largest_m = std::max(largest_m, std::abs(vertex.norm() - kRadius_m));
  return largest_m;
}

// Of facets that do not face away from the ball's centre.
int turned_inward(const Surface& surface) {
  int count = 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto at = [&](int k) { return Vec3(surface.vertices.row(surface.triangles(t, k))); };
    count += !((at(1) - at(0)).cross(at(2) - at(0)).dot(at(0)) > 0);
  }
  return count;
}

TEST(contact_surface, of_a_window_is_a_height_field_that_faces_outward) {
  const Contacts contacts = on_ball(80, 0.1, 0);
  const ContactSurface made = surface_from_contacts(contacts);
  EXPECT_TRUE(made.is_height_field);
  EXPECT_GT(made.surface.triangles.rows(), 150);
  EXPECT_EQ(turned_inward(made.surface), 0);
  EXPECT_LT(largest_off_ball_m(made, contacts), 0.05 * made.spacing_m);
  EXPECT_TRUE(surface_from_contacts(on_ball(80, 0.29, 0)).is_height_field) << "to 65 degrees";
}

// Once it reached two spacings beyond them, where it was 5 mm off and curled up.
TEST(contact_surface, ends_soon_beyond_the_contacts_and_is_right_there) {
  const Contacts contacts = on_ball(6, 0.008, 1e-5);
  const ContactSurface made = surface_from_contacts(contacts);
  for (const auto& vertex : made.surface.vertices.rowwise()) {
    EXPECT_LT((contacts.position.rowwise() - vertex).rowwise().norm().minCoeff(),
              1.6 * made.spacing_m);  // along a slope it is farther than in the plane
    EXPECT_NEAR(vertex.norm(), kRadius_m, 0.03 * made.spacing_m);
  }
}

TEST(contact_surface, passes_through_every_contact_noise_and_all) {
  const Contacts contacts = on_ball(80, 0.1, 2e-4);
  const Points& vertices = surface_from_contacts(contacts).surface.vertices;
  for (Eigen::Index i = 0; i < contacts.position.rows(); ++i)
    EXPECT_EQ((vertices.rowwise() - contacts.position.row(i)).rowwise().norm().minCoeff(), 0) << i;
}

TEST(contact_surface, contacts_left_out_lie_off_by_their_noise) {
  for (const double noise_m : {5e-5, 2e-4, 1e-3}) {
    const Eigen::VectorXd off_m = surface_from_contacts(on_ball(120, 0.1, noise_m)).left_out_m;
    std::vector<double> sizes;
    for (const double m : off_m) sizes.push_back(std::abs(m));
    std::ranges::sort(sizes);
    // 0.67 of the deviation is the median of noise itself; a surface of noisy ones adds to it.
    EXPECT_GT(sizes[60], 0.5 * noise_m);
    EXPECT_LT(sizes[60], 1.3 * noise_m);
  }
}

TEST(contact_surface, says_on_which_side_a_contact_lies) {
  Contacts contacts = on_ball(80, 0.1, 0);
  contacts.position.row(20) *= 1 + 1e-3 / kRadius_m;  // 1 mm outward
  const Eigen::VectorXd off_m = surface_from_contacts(contacts).left_out_m;
  EXPECT_NEAR(off_m[20], 1e-3, 5e-5);
}

TEST(contact_surface, of_contacts_all_around_closes) {
  const ContactSurface made = surface_from_contacts(on_ball(200, 1, 0));
  EXPECT_FALSE(made.is_height_field);
  EXPECT_EQ(made.surface.vertices.rows(), 200);
  EXPECT_EQ(made.surface.triangles.rows(), 396);  // 2 V - 4
  EXPECT_EQ(turned_inward(made.surface), 0);
}

TEST(contact_surface, refuses_what_is_no_surface) {
  const auto what = [](const Contacts& contacts) {
    return testing_support::fact_of([&] { surface_from_contacts(contacts); });
  };
  EXPECT_EQ(what(on_ball(5, 0.1, 0)), "5 places are too few for a surface");
  Contacts line = on_ball(10, 0.1, 0);
  for (int i = 0; i < 10; ++i) line.position.row(i) = Vec3(1e-3 * i, 0, 0);
  EXPECT_EQ(what(line), "all lie on one line, which is no surface");
}

}  // namespace
}  // namespace palpate
