// Opening an asset trusts nothing. Run under sanitizers this is the proof that it reads no byte
// outside and overflows nowhere.

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "tests/libfit/assets/changed_bytes.hpp"

namespace palpate::test {
namespace {

// The asset with one change and a good checksum.
Status open_changed(const std::function<void(unsigned char*, Header&)>& change) {
  AssetBytes bytes = small_asset();
  Header header = header_of(bytes);
  change(bytes.data(), header);
  std::memcpy(bytes.data(), &header, sizeof header);
  fix_checksum(bytes, bytes.size());
  return open(bytes, bytes.size());
}

template <class T>
void poke(unsigned char* data, const Header& header, int section, std::size_t index, T value) {
  std::memcpy(data + header.offset[section] + index * sizeof(T), &value, sizeof value);
}

TEST(hostile_bytes, the_asset_itself_opens) {
  const AssetBytes bytes = small_asset();
  EXPECT_EQ(open(bytes, bytes.size()), Status::ok);
  EXPECT_EQ(bytes.size() % 64, 0U);
}

TEST(hostile_bytes, every_truncation_is_refused) {
  const AssetBytes bytes = small_asset();
  for (std::size_t size = 0; size < bytes.size(); size += size < 1024 ? 1 : 61) {
    AssetBytes cut(bytes.size());
    std::memcpy(cut.data(), bytes.data(), size);
    EXPECT_NE(open(cut, size), Status::ok) << size;
    if (size < sizeof(Header)) continue;
    const std::uint64_t claimed = size;  // and with a header that agrees
    std::memcpy(cut.data() + offsetof(Header, file_bytes), &claimed, sizeof claimed);
    fix_checksum(cut, size);
    EXPECT_NE(open(cut, size), Status::ok) << size;
  }
}

TEST(hostile_bytes, every_changed_byte_is_refused_by_the_checksum_or_before) {
  const AssetBytes bytes = small_asset();
  std::mt19937 random(5);
  for (int round = 0; round < 3000; ++round) {
    AssetBytes changed = bytes;
    changed.data()[random() % bytes.size()] ^= static_cast<unsigned char>(1 + random() % 255);
    ASSERT_NE(open(changed, changed.size()), Status::ok) << "seed 5, round " << round;
  }
}

TEST(hostile_bytes, changed_bytes_with_a_good_checksum_never_harm) {
  // Many such assets are good (a moved vertex, another friction): then their forces are finite.
  const AssetBytes bytes = small_asset();
  std::mt19937 random(6);
  int refused = 0, opened = 0;
  for (int round = 0; round < 6000; ++round) {
    AssetBytes changed = bytes;
    const int flips = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < flips; ++i) {
      const std::size_t reach = round % 3 == 0 ? sizeof(Header) : bytes.size();
      changed.data()[random() % reach] ^= static_cast<unsigned char>(1 << random() % 8);
    }
    fix_checksum(changed, changed.size());
    Status status;
    Asset asset = Asset::open(changed.data(), changed.size(), &status);
    if (status == Status::replay_differs)  // what an attacker would do next: touch it nevertheless
      asset = Asset::open_without_replay(changed.data(), changed.size(), &status);
    ++(status == Status::ok ? opened : refused);
    if (!asset.is_open()) continue;
    Tool tool(asset);
    for (int tick = 0; tick < 60; ++tick) {
      const double t = tick / 60.0;
      const Vec3 f = tool.tick(
          {0.03 * std::sin(4 * t), 0.02 * std::sin(9 * t), 0.033 - 0.02 * std::sin(6 * t)});
      ASSERT_TRUE(f.allFinite()) << "seed 6, round " << round;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(opened, 500);
}

TEST(hostile_bytes, each_fault_has_its_status) {
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  const Header whole = header_of(small_asset());
  const auto header = [](const std::function<void(Header&)>& change) {
    return open_changed([&](unsigned char*, Header& h) { change(h); });
  };
  const auto poked = [](int section, std::size_t index, auto value) {
    return open_changed(
        [=](unsigned char* data, Header& h) { poke(data, h, section, index, value); });
  };
  EXPECT_EQ(header([](Header& h) { h.magic[0] = 'Q'; }), Status::not_an_asset);
  EXPECT_EQ(header([](Header& h) { h.endian_mark = 0x04030201; }), Status::other_endianness);
  EXPECT_EQ(header([](Header& h) { h.version = runtime::kVersion + 1; }), Status::other_version);
  EXPECT_EQ(header([](Header& h) { h.file_bytes += 64; }), Status::size_wrong);
  EXPECT_EQ(header([](Header& h) { h.vertices = -1; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.triangles = 1 << 30; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.meta_bytes = ~std::uint64_t{0}; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.offset[3] += 64; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.degree[1] = 5; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.origin_m[1] = std::numeric_limits<double>::infinity(); }),
            Status::numbers_wrong);
  EXPECT_EQ(header([](Header& h) { h.max_step_m = 0; }), Status::numbers_wrong);
  EXPECT_EQ(poked(runtime::kVertices, 7, nan), Status::vertices_wrong);
  EXPECT_EQ(poked(runtime::kTriangles, 4, whole.vertices), Status::triangles_wrong);
  EXPECT_EQ(poked(runtime::kTriangles, 4, -1), Status::triangles_wrong);
  EXPECT_EQ(poked(runtime::kNeighbours, 0, whole.triangles), Status::neighbours_wrong);
  EXPECT_EQ(poked(runtime::kNeighbours, 0, 5), Status::neighbours_wrong);
  EXPECT_EQ(poked(runtime::kNormals, 2, 3.0F), Status::normals_wrong);
  EXPECT_EQ(poked(runtime::kNormals, 0, nan), Status::normals_wrong);
  EXPECT_EQ(poked(runtime::kControls, 3, -1.0F), Status::controls_wrong);
  EXPECT_EQ(poked(runtime::kControls, 3, nan), Status::controls_wrong);
  EXPECT_EQ(poked(runtime::kControls, 0, 1.0F), Status::controls_wrong);
  for (const std::int32_t record : {-1, 1 << 30})
    EXPECT_EQ(poked(runtime::kRecords, 4, record), Status::controls_wrong);
  EXPECT_EQ(header([](Header& h) { h.records = 0; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.records = h.vertices + 1; }), Status::layout_wrong);
  EXPECT_EQ(header([](Header& h) { h.visual_vertices = 1; }), Status::layout_wrong);
  EXPECT_EQ(poked(runtime::kCovered, 2, std::uint8_t{0}), Status::controls_wrong);
  EXPECT_EQ(poked(runtime::kPartTable, 2, 0.0), Status::curves_wrong);
  EXPECT_EQ(poked(runtime::kPartTable + 2, 12, 0.5), Status::curves_wrong);
  EXPECT_EQ(poked(runtime::kMaxDepth, 1, nan), Status::triangles_wrong);
  EXPECT_EQ(poked(runtime::kTreeNodes, 6, 0), Status::tree_wrong);
  EXPECT_EQ(poked(runtime::kTreeNodes, 6, whole.tree_nodes), Status::tree_wrong);
  EXPECT_EQ(poked(runtime::kTreeItems, 0, whole.triangles), Status::tree_wrong);
  EXPECT_EQ(poked(runtime::kCheckTicks, 15 * 6 + 5, 1.0), Status::replay_differs);
}

// A weight of basis function k on interval i, power m, of a part.
std::size_t weight_at(const Header& h, int part, int i, int k, int m) {
  const int order = h.degree[part] + 1;
  return static_cast<std::size_t>(h.pieces[part] + 1 + (i * order + k) * order + m);
}
void add(unsigned char* data, const Header& header, int section, std::size_t at, double by) {
  double value;
  std::memcpy(&value, data + header.offset[section] + at * sizeof value, sizeof value);
  poke(data, header, section, at, value + by);
}

TEST(hostile_bytes, a_basis_that_pulls_and_integrals_of_another_are_refused) {
  using D = unsigned char*;
  const int table = runtime::kPartTable;
  for (const double by : {-0.5, 0.5, 1e-3})  // the sum stays one
    EXPECT_EQ(open_changed([=](D d, Header& h) {
                add(d, h, table, weight_at(h, 0, 0, 1, 0), by);
                add(d, h, table, weight_at(h, 0, 0, 0, 0), -by);
              }),
              Status::curves_wrong)
        << by;
  EXPECT_EQ(open_changed([=](D d, Header& h) {  // falls beyond the last knot
              add(d, h, table, weight_at(h, 0, h.pieces[0], h.degree[0], 1), -1e4);
              add(d, h, table, weight_at(h, 0, h.pieces[0], 0, 1), 1e4);
            }),
            Status::curves_wrong);
  EXPECT_EQ(open_changed([=](D d, Header& h) {  // of the last row: the whole area of a function
              const int order = h.degree[0] + 1, size = h.pieces[0] + h.degree[0];
              const int at = (h.pieces[0] + 1) * (1 + order * order) + h.pieces[0] * size + 1;
              add(d, h, table, static_cast<std::size_t>(at), 1e-5);
            }),
            Status::curves_wrong);
}

// Where large weights excuse what the functions' sum lacks, or the last interval is narrow.
TEST(hostile_bytes, tails_above_one_and_slow_falls_beyond_narrow_intervals_are_refused) {
  const auto check = [](const SplineTables& t) {
    return runtime::check_spline(
        {t.degree, t.pieces, t.knots.data(), t.weights.data(), t.integrals.data()});
  };
  constexpr double kEnd_m = 0.01;
  SplineTables steep = tabulate(CurveBasis{1, {0, kEnd_m}});
  ASSERT_EQ(check(steep), Status::ok);
  double* w = steep.weights.data();  // value, slope of function 0 and 1, twice
  w[1] = w[5] = -1e11 - 9e4;         // the sum falls to -899
  w[3] = w[7] = 1e11, w[4] = 1 - 1e9, w[6] = 1e9;
  for (int k = 0; k < 2; ++k)
    steep.integrals[static_cast<std::size_t>(2 + k)] =
        runtime::basis_integral(w + 2 * k, 2, kEnd_m) * kEnd_m;
  EXPECT_EQ(check(steep), Status::curves_wrong);

  SplineTables narrow = tabulate(CurveBasis{1, {0, kEnd_m, kEnd_m + 1e-7}});
  ASSERT_EQ(check(narrow), Status::ok);
  const double by = 1e7 + 5e-3;  // the last slope is 1e7 per metre; now it is -5e-3
  narrow.weights[9] += by;
  narrow.weights[11] -= by;
  EXPECT_EQ(check(narrow), Status::curves_wrong);
}

TEST(hostile_bytes, a_tree_with_an_infinite_root_is_refused) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(open_changed([](unsigned char* d, Header& h) {
              poke(d, h, runtime::kTreeNodes, 3, kInfinity);  // hi.x of the root
            }),
            Status::tree_wrong);
}

TEST(hostile_bytes, a_tree_with_a_hole_no_check_ticks_and_absurd_depths_are_refused) {
  using D = unsigned char*;
  EXPECT_EQ(open_changed([](D d, Header& h) {  // one triangle twice, another never
              std::int32_t first;
              std::memcpy(&first, d + h.offset[runtime::kTreeItems], sizeof first);
              poke(d, h, runtime::kTreeItems, 1, first);
            }),
            Status::tree_wrong);
  EXPECT_EQ(open_changed([](D d, Header& h) { poke(d, h, runtime::kMaxDepth, 3, 900.0F); }),
            Status::triangles_wrong);
  const AssetBytes bare = with_fewer_check_ticks(small_asset(), 0);
  EXPECT_EQ(open(bare, bare.size()), Status::layout_wrong);
}

TEST(hostile_bytes, an_older_law_is_met_within_a_millionth_and_a_newer_one_is_refused) {
  using D = unsigned char*;
  const auto open_revision = [](int revision, double share) {
    return open_changed([=](D d, Header& h) {
      h.law_revision = revision;
      double peak = 0;
      auto* check = reinterpret_cast<runtime::CheckTick*>(d + h.offset[runtime::kCheckTicks]);
      for (int i = 0; i < h.check_ticks; ++i)
        for (double f : check[i].force_on_tool_N) peak = std::max(peak, std::abs(f));
      ASSERT_GT(peak, 0.1);
      for (int i = 0; i < h.check_ticks; ++i)
        if (check[i].force_on_tool_N[0] != 0) check[i].force_on_tool_N[0] += share * peak;
    });
  };
  constexpr int kNow = runtime::kLawRevision;
  EXPECT_EQ(open_revision(kNow, 0), Status::ok);
  EXPECT_EQ(open_revision(kNow, 1e-15), Status::replay_differs);
  EXPECT_EQ(open_revision(kNow - 1, 5e-7), Status::ok);
  EXPECT_EQ(open_revision(kNow - 1, 2e-6), Status::replay_differs);
  EXPECT_EQ(open_revision(kNow + 1, 0), Status::other_version);
}

TEST(hostile_bytes, nothing_null_and_misaligned_are_refused) {
  const AssetBytes bytes = small_asset();
  Status status;
  EXPECT_FALSE(Asset::open(nullptr, 1000, &status).is_open());
  EXPECT_EQ(status, Status::bytes_missing);
  AssetBytes moved(bytes.size() + 64);
  std::memcpy(moved.data() + 4, bytes.data(), bytes.size());
  EXPECT_FALSE(Asset::open(moved.data() + 4, bytes.size(), &status).is_open());
  EXPECT_EQ(status, Status::bytes_misaligned);
  EXPECT_TRUE(Asset::open(bytes.data(), bytes.size(), nullptr).is_open());
}

// palpate_open refused what fread had put where malloc said, and the README's lines felt nothing.
TEST(hostile_bytes, bytes_that_begin_at_any_multiple_of_8_open) {
  const AssetBytes bytes = small_asset();
  for (std::size_t skip = 8; skip < 64; skip += 8) {
    AssetBytes moved(bytes.size() + 64);
    std::memcpy(moved.data() + skip, bytes.data(), bytes.size());
    Status status;
    EXPECT_TRUE(Asset::open(moved.data() + skip, bytes.size(), &status).is_open());
    EXPECT_EQ(status, Status::ok) << skip << ": " << sentence(status);
  }
}

// 10^15 N/m^2 was admitted: 4e10 N beside a press of 1 N.
TEST(hostile_bytes, a_side_force_that_no_press_bears_is_refused) {
  const auto open_with = [](int part, float number) {
    AssetBytes bytes = golden_rings();
    const Header header = header_of(bytes);
    Status status;
    const Asset asset = Asset::open(bytes.data(), bytes.size(), &status);
    EXPECT_EQ(status, Status::ok);
    int v = 0;
    while (!asset.covered[v]) ++v;
    const auto at =
        reinterpret_cast<const unsigned char*>(asset.node(v) + asset.control_offset[part]) -
        bytes.data();
    std::memcpy(bytes.data() + at, &number, sizeof number);
    fix_checksum(bytes, bytes.size());
    EXPECT_EQ(header.family, int(runtime::Family::rings));
    return Asset::open_without_replay(bytes.data(), bytes.size(), &status), status;
  };
  EXPECT_EQ(open_with(runtime::kSide2, 1e3F), Status::ok);
  EXPECT_EQ(open_with(runtime::kSide2, 1e15F), Status::controls_wrong);
  EXPECT_EQ(open_with(runtime::kSide2, -1e6F), Status::controls_wrong);
  EXPECT_EQ(open_with(runtime::kSide3, 1e5F), Status::ok);
  EXPECT_EQ(open_with(runtime::kSide3, 1e15F), Status::controls_wrong);
  EXPECT_EQ(open_with(runtime::kSpread, 1e7F), Status::controls_wrong);
}

}  // namespace
}  // namespace palpate::test
