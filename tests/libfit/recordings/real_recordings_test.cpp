// Real recordings, where they are there.

#include <gtest/gtest.h>

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate::recordings {
namespace {

namespace fs = std::filesystem;

class RealRecordings : public testing::Test {
 protected:
  void SetUp() override { PALPATE_NEEDS_DATA("data/indentation"); }
  std::vector<BatchItem> items(const std::string& sub, const std::string& begins) const {
    std::vector<BatchItem> out;
    for (const auto& entry : fs::directory_iterator(folder_ / sub)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(begins) || entry.is_directory()) continue;
      BatchItem item;
      item.file = entry.path();
      item.shown = name;
      item.position_m = Vec3::Zero();
      item.normal = Vec3(0, 0, -1);
      out.push_back(std::move(item));
    }
    std::sort(out.begin(), out.end(),
              [](const auto& a, const auto& b) { return a.shown < b.shown; });
    return out;
  }
  fs::path folder_ = testing_support::shared_data("data");
};

// The instrument's own result stands in the file: E[v=0.500] (Pa) 117.007.
TEST_F(RealRecordings, a_hertz_fit_with_free_contact_gives_the_nanoindenters_own_modulus) {
  for (const char* estimator : {"hertz", "auto"}) {
    auto batch = items("indentation", "fmt-chiaro");
    ASSERT_EQ(batch.size(), 1u);
    batch[0].signal.contact = estimator;
    const auto results = run_batch(batch, {}, {});
    ASSERT_FALSE(results[0].failure) << results[0].failure->what;
    const Conditioned& r = results[0].recordings[0];
    std::printf("%s: E = %.1f Pa, contact at %.3f um +- %.3f um\n", estimator, r.young_Pa,
                1e6 * r.contact.travel_m, 1e6 * r.contact.deviation_m);
    EXPECT_NEAR(r.young_Pa, 117.007, 0.03 * 117.007);
    for (Eigen::Index i = 10; i + 1 < r.force_N.rows(); ++i)
      EXPECT_GT(r.force_N(i + 1, 0), r.force_N(i, 0) - 0.05 * r.force_N.col(0).maxCoeff()) << i;
  }
}

TEST_F(RealRecordings, five_compressions_of_a_phantom_pool_to_one_curve_with_their_scatter) {
  auto batch = items("compression", "EF10_100T");
  ASSERT_EQ(batch.size(), 5u);
  for (BatchItem& item : batch) {
    item.point = "EF10_100T";
    item.signal.tip = Tip::flat;
  }
  const Assembled out = assemble(batch, run_batch(batch, {}, {}), {});
  EXPECT_EQ(out.failed(), 0u);
  ASSERT_EQ(out.samples.points(), 1);
  EXPECT_EQ(out.samples.recordings.size(), 5u);
  const Eigen::Index last = out.samples.rows() - 1;
  EXPECT_NEAR(-out.samples.force(last, 2), 75, 5);  // 74.8 to 84.1 N at 20 mm, recorded
  EXPECT_GT(out.samples.force_error[last], 0.3);
}

TEST_F(RealRecordings, a_force_map_becomes_a_point_per_curve_at_its_place) {
  auto batch = items("indentation/afm-workshop-map16", "AFM");
  ASSERT_EQ(batch.size(), 16u);
  for (BatchItem& item : batch) {
    item.position_m.reset();
    item.read.cantilever = importers::Cantilever{0.2, 1e-7};
    item.signal.min_young_Pa = 1;
    item.signal.max_young_Pa = 1e9;
    item.signal.is_range_given = true;
  }
  AssembleOptions options;
  options.place_tolerance_m = 1e-6;
  const Assembled out = assemble(batch, run_batch(batch, {}, {}), options);
  EXPECT_EQ(out.failed(), 0u);
  EXPECT_EQ(out.samples.points(), 16);
  EXPECT_NEAR(extent_m(out.samples.point_position).x(), 19e-6, 1e-9);
}

TEST_F(RealRecordings, the_single_afm_curves_are_read) {
  auto batch = items("indentation", "afm-workshop-fd");
  for (auto& item : items("indentation", "ntmdt")) batch.push_back(item);
  ASSERT_EQ(batch.size(), 3u);
  for (BatchItem& item : batch) item.read.cantilever = importers::Cantilever{0.2, 1e-7};
  for (const ItemResult& result : run_batch(batch, {}, {}))
    EXPECT_FALSE(result.failure) << result.failure->where << result.failure->what;
}

}  // namespace
}  // namespace palpate::recordings
