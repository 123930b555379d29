// Real recordings, where they are there.

#include <gtest/gtest.h>

#include "libfit/recordings/batch/batch.hpp"
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

TEST_F(RealRecordings, five_compressions_of_a_phantom_pool_to_one_curve_with_their_scatter) {
  auto batch = items("compression", "EF10_100T");
  ASSERT_EQ(batch.size(), 5u);
  for (BatchItem& item : batch) {
    item.point = "EF10_100T";
    item.signal.tip = Tip::flat;
    item.read.is_force_on_tool = false;
  }
  const Assembled out = assemble(batch, run_batch(batch, {}, {}), {});
  EXPECT_EQ(out.failed(), 0u);
  ASSERT_EQ(out.samples.points(), 1);
  EXPECT_EQ(out.samples.recordings.size(), 5u);
  const Eigen::Index last = out.samples.rows() - 1;
  EXPECT_NEAR(-out.samples.force(last, 2), 75, 5);  // 74.8 to 84.1 N at 20 mm, recorded
  EXPECT_GT(out.samples.force_error[last], 0.3);
}

}  // namespace
}  // namespace palpate::recordings
