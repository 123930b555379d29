// Assets in the field stay readable: every version that was released has a file here.
// Made by tests/libfit/runtime/golden/make_golden.

#include <gtest/gtest.h>

#include "libfit/io/atomic_file.hpp"
#include "tests/libfit/runtime/golden/golden_asset.hpp"

namespace palpate::test {
namespace {

std::string golden_file(int version) {
  return read_whole_file(PALPATE_GOLDEN "/version_" + std::to_string(version) + ".palp");
}

TEST(golden, every_version_opens_and_replays_its_own_forces) {
  for (int version = 1; version <= int(runtime::kVersion); ++version) {
    const std::string file = golden_file(version);
    AssetBytes bytes(file.size());
    std::memcpy(bytes.data(), file.data(), file.size());
    Status status;
    const Asset asset = Asset::open(bytes.data(), bytes.size(), &status);
    ASSERT_EQ(status, Status::ok) << version << ": " << sentence(status);
    EXPECT_EQ(asset.file.version, static_cast<std::uint32_t>(version));
    EXPECT_EQ(asset.curves.family, int(CurveFamily::separable));
    EXPECT_EQ(asset.check.ticks, 64);
    EXPECT_EQ(std::string(asset.file.meta, asset.file.meta_bytes),
              "{\"golden\": \"version " + std::to_string(version) + "\"}");
    double force_N = 0;
    for (int i = 0; i < asset.check.ticks; ++i)
      force_N = std::max(force_N, Vec3::Map(asset.check.tick[i].force_on_tool_N).norm());
    EXPECT_GT(force_N, 0.1) << "the check path touches nothing";
    EXPECT_LT(file.size(), 16384U);
  }
}

}  // namespace
}  // namespace palpate::test
