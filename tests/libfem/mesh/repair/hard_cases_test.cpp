// Random soups and real files: mended into something sound, or refused, and in seconds.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <random>

#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/repair/shapes.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate {
namespace {

using namespace mesh_repair_test;

// True when mended; what comes back must be sound either way.
bool mends_soundly(const Surface& surface, const MendOptions& options) {
  try {
    const SurfaceFacts facts = surface_facts(mend_surface(surface, options, "soup").surface);
    EXPECT_TRUE(facts.is_manifold && facts.is_oriented);
    EXPECT_TRUE(facts.is_closed || options.allow_open);
    EXPECT_TRUE(facts.volume_m3 > 0 || !facts.is_closed);
    return true;
  } catch (const Error& error) {
    EXPECT_FALSE(error.fact().empty());
    return false;
  }
}

TEST(HardCases, random_soups_are_mended_or_refused) {
  int mended = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const int vertices = 4 + static_cast<int>(random() % 12),
              faces = 4 + static_cast<int>(random() % 30);
    Surface soup{Points(vertices, 3), Triangles(faces, 3)};
    // A coarse lattice, so that vertices coincide and triangles are flat, coplanar and crossing.
    for (Eigen::Index i = 0; i < soup.vertices.size(); ++i)
      soup.vertices.data()[i] = static_cast<double>(random() % 4);
    for (Eigen::Index i = 0; i < soup.triangles.size(); ++i)
      soup.triangles.data()[i] =
          static_cast<std::int32_t>(random() % static_cast<unsigned>(vertices));
    mended += mends_soundly(soup, {.allow_open = seed % 2 == 0});
  }
  RecordProperty("mended", mended);
}

TEST(HardCases, bodies_damaged_at_random_are_mended_or_refused) {
  int mended = 0;
  constexpr unsigned kCases = 60;
  for (unsigned seed = 1; seed <= kCases; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Surface body = ball(0.05, Vec3::Zero(), 12);
    const auto faces = static_cast<unsigned>(body.triangles.rows()),
               vertices = static_cast<unsigned>(body.vertices.rows());
    for (int damage = 0; damage < 4; ++damage) {
      const auto f = static_cast<Eigen::Index>(random() % faces),
                 g = static_cast<Eigen::Index>(random() % faces);
      switch (random() % 5) {
        case 0:
          std::swap(body.triangles(f, 0), body.triangles(f, 1));
          break;
        case 1:
          body.triangles.row(f) = body.triangles.row(g);
          break;
        case 2:
          body.triangles(f, 0) = static_cast<std::int32_t>(random() % vertices);
          break;
        case 3:
          body.triangles(f, 0) = body.triangles(f, 1);
          break;
        case 4:
          body.vertices.row(static_cast<Eigen::Index>(random() % vertices)) *= 0.7;
          break;
      }
    }
    mended += mends_soundly(body, {});
  }
  EXPECT_GT(mended, 30) << "of " << kCases;
}

struct RealCase {
  const char* file;
  bool is_mended;
  const char* says;
};
void PrintTo(const RealCase& real, std::ostream* out) { *out << real.file; }

class RealFile : public testing::TestWithParam<RealCase> {};
INSTANTIATE_TEST_SUITE_P(
    Files, RealFile,
    testing::Values(RealCase{"sofa_liver.vtk", true, "dropped 3 stray pieces of 12 triangles"},
                    RealCase{"sofa_liver.vtk", true, "turned 9988 triangles outward"},
                    RealCase{"sofa_liver-smooth.obj", true,
                             "removed 7 crossing pairs of triangles"},
                    RealCase{"sofa_liver2.obj", true, ""},
                    RealCase{"odedstein_hand_closed.obj", true, ""},
                    RealCase{"sofa_c_open.obj", true, "filled 2 holes"},
                    RealCase{"cgal_elephant-with-holes.off", true, "filled 106 holes"},
                    RealCase{"sofa_dragon.obj", false, "crosses itself in"}),
    [](const auto& real) {
      return testing_support::file_as_name(real.param.file) + "_" + std::to_string(real.index);
    });

TEST_P(RealFile, is_mended_or_refused_as_documented_in_seconds) {
  PALPATE_NEEDS_DATA("data/surfaces");
  const auto path = testing_support::shared_data("data/surfaces") / GetParam().file;
  const Surface surface = read_surface(path, 1e-3);
  const auto start = std::chrono::steady_clock::now();
  std::string text;
  bool is_mended = true;
  try {
    const Mended mended = mend_surface(surface, {}, GetParam().file);
    const SurfaceFacts facts = surface_facts(mended.surface);
    EXPECT_TRUE(facts.is_closed && facts.is_manifold && facts.is_oriented && facts.volume_m3 > 0);
    for (const std::string& change : mended.changes) text += change + "\n";
    if (GetParam().says[0] == '\0') {
      EXPECT_EQ(text, "");
      EXPECT_EQ(mended.surface.triangles, surface.triangles);
    }
  } catch (const Error& error) {
    is_mended = false;
    text = error.what();
  }
  EXPECT_EQ(is_mended, GetParam().is_mended) << text;
  EXPECT_NE(text.find(GetParam().says), std::string::npos) << text;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_LT(seconds.count(), 10) << GetParam().file;
}

TEST(HardCases, the_dragon_is_wrapped_when_asked) {
  PALPATE_NEEDS_DATA("data/surfaces");
  const auto path = testing_support::shared_data("data/surfaces/sofa_dragon.obj");
  EXPECT_TRUE(mends_soundly(read_surface(path, 1e-3), {.wrap_alpha_m = 6e-4}));
}

}  // namespace
}  // namespace palpate
