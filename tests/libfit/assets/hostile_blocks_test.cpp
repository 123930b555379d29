// Opening trusts nothing of the blocks behind an asset's sections either: how the surface moves,
// how a body relaxes.

#include <limits>
#include <random>

#include "tests/libfit/assets/changed_bytes.hpp"

namespace palpate::test {
namespace {

AssetBytes small_shaped_asset() {
  Model model = sphere_model(0.03, 6, uniform(400, 300, 0.3));
  make_shaped(model, 5, 2, 4);
  return make_asset_bytes(model, {.meta_json = "{\"a\": 1}"});
}

// The shaped asset with one change to the part of its shape response, and a good checksum.
template <class T>
Status open_shape_changed(int part, std::size_t index, T value) {
  AssetBytes bytes = small_shaped_asset();
  const Header header = header_of(bytes);
  std::uint64_t sections[runtime::kSections], parts[runtime::kShapeParts];
  unsigned char* shape = bytes.data() + runtime::lay_out(header, sections);
  runtime::ShapeHeader counts;
  std::memcpy(&counts, shape, sizeof counts);
  runtime::lay_out_shape(counts, header, parts);
  const std::uint64_t at = part < 0 ? 0 : parts[part];
  std::memcpy(shape + at + index * sizeof value, &value, sizeof value);
  fix_checksum(bytes, bytes.size());
  return open(bytes, bytes.size());
}

TEST(hostile_blocks, a_shape_response_is_refused_for_every_fault_of_its_own) {
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  const AssetBytes whole = small_shaped_asset();
  EXPECT_EQ(open(whole, whole.size()), Status::ok);
  constexpr int kCounts = -1;
  for (const std::int32_t wrong : {-1, 0, 6, 1 << 30})  // points
    EXPECT_EQ(open_shape_changed(kCounts, 0, wrong), Status::layout_wrong) << wrong;
  for (const std::int32_t wrong : {-1, 0, 33, 1 << 30})  // intervals
    EXPECT_EQ(open_shape_changed(kCounts, 1, wrong), Status::layout_wrong) << wrong;
  for (const std::int32_t wrong : {-1, 3, 33, 1 << 30})  // modes
    EXPECT_EQ(open_shape_changed(kCounts, 2, wrong), Status::layout_wrong) << wrong;
  EXPECT_EQ(open_shape_changed(kCounts, 3, std::int32_t{3}), Status::layout_wrong);
  EXPECT_EQ(open_shape_changed(kCounts, 5, 1e-300), Status::layout_wrong);  // reserved
  for (const double wrong : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
    for (const std::size_t length : {2, 3})
      EXPECT_EQ(open_shape_changed(kCounts, length, wrong), Status::shape_wrong) << wrong;
  EXPECT_EQ(open_shape_changed(runtime::kShapeBlendPoint, 7, std::int32_t{5}), Status::shape_wrong);
  EXPECT_EQ(open_shape_changed(runtime::kShapeBlendPoint, 7, -1), Status::shape_wrong);
  for (const float wrong : {-0.1F, 0.9F, nan})
    EXPECT_EQ(open_shape_changed(runtime::kShapeBlendWeight, 7, wrong), Status::shape_wrong);
  for (const int part :
       {int(runtime::kShapePoint), int(runtime::kShapeDrag), int(runtime::kShapeMode)})
    for (const float wrong : {nan, 2e6F, -std::numeric_limits<float>::infinity()})
      EXPECT_EQ(open_shape_changed(part, 3, wrong), Status::shape_wrong) << part;
}

AssetBytes small_relaxing_asset() {
  Model model = sphere_model(0.03, 6, uniform(400, 300, 0.3));
  make_rings(model, 1, 0.03, even);
  model.curves.relaxation.share = Eigen::Vector2d(0.5, 0.8);
  model.curves.relaxation.time_s = Eigen::Vector2d(0.05, 0.6);
  return make_asset_bytes(model, {.meta_json = "{\"a\": 1}"});
}

TEST(hostile_blocks, a_relaxation_is_refused_for_every_fault_of_its_own) {
  const AssetBytes whole = small_relaxing_asset();
  ASSERT_EQ(open(whole, whole.size()), Status::ok);
  const auto changed = [&](std::size_t byte, auto value) {
    AssetBytes bytes = whole;
    std::memcpy(bytes.data() + whole.size() - sizeof(runtime::RelaxationBlock) + byte, &value,
                sizeof value);
    fix_checksum(bytes, bytes.size());
    return open(bytes, bytes.size());
  };
  using Block = runtime::RelaxationBlock;
  for (const std::int64_t wrong : {-1L, 0L, 1L, 3L, 4L, 1L << 40})
    EXPECT_EQ(changed(offsetof(Block, branches), wrong), Status::block_wrong) << wrong;
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  for (const double wrong : {0.0, -1.0, 2e3, nan})
    EXPECT_EQ(changed(offsetof(Block, share) + 8, wrong), Status::block_wrong) << wrong;
  for (const double wrong : {0.0, -1.0, 0.05, 1e-5, 2e6, nan})
    EXPECT_EQ(changed(offsetof(Block, time_s) + 8, wrong), Status::block_wrong) << wrong;
  EXPECT_EQ(changed(offsetof(Block, share) + 16, 0.1), Status::block_wrong);
  EXPECT_EQ(changed(offsetof(Block, radius_m), -1e-3), Status::block_wrong);
  EXPECT_EQ(changed(offsetof(Block, share), 0.6), Status::replay_differs);
  AssetBytes other = small_asset();  // separable curves have no memory of time
  Header header = header_of(other);
  header.flags |= runtime::RelaxationBlock::kFlag;
  std::memcpy(other.data(), &header, sizeof header);
  fix_checksum(other, other.size());
  EXPECT_EQ(open(other, other.size()), Status::layout_wrong);
  EXPECT_EQ(open(whole, whole.size() - sizeof(Block)), Status::size_wrong);
}

TEST(hostile_blocks, changed_bytes_of_a_shape_response_never_harm) {
  const AssetBytes bytes = small_shaped_asset();
  const Header header = header_of(bytes);
  std::uint64_t sections[runtime::kSections];
  const std::uint64_t from = runtime::lay_out(header, sections);
  std::mt19937 random(8);
  int refused = 0, opened = 0;
  for (int round = 0; round < 3000; ++round) {
    AssetBytes changed = bytes;
    const std::uint64_t reach = round % 3 == 0 ? sizeof(runtime::ShapeHeader) : bytes.size() - from;
    changed.data()[from + random() % reach] ^= static_cast<unsigned char>(1 << random() % 8);
    fix_checksum(changed, changed.size());
    Status status;
    const Asset asset = Asset::open(changed.data(), changed.size(), &status);
    ++(status == Status::ok ? opened : refused);
    if (!asset.is_open()) continue;
    Tool tool(asset);
    std::vector<float> moved(3 * static_cast<std::size_t>(asset.vertices));
    for (int tick = 0; tick < 20; ++tick) {
      tool.tick({0.002 * tick, 0, 0.033 - 0.0007 * tick});
      runtime::deform(asset, tool.contact, 0, 0, asset.vertices, moved.data());
      for (const float x : moved) ASSERT_TRUE(std::isfinite(x)) << "seed 8, round " << round;
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(opened, 300);
}

}  // namespace
}  // namespace palpate::test
