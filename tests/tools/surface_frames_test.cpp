// `palpate replay --surface`: the frames that ParaView plays, read back.

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/tools/kept_run.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

/// A .vtu as this program writes them: arrays by their names.
struct Vtu {
  explicit Vtu(const fs::path& path) : text(content_of(path)) {
    EXPECT_TRUE(holds(text, "<VTKFile type=\"UnstructuredGrid\"")) << path;
  }
  template <class T>
  std::vector<T> values(const std::string& name) const {
    const std::size_t at = text.find("Name=\"" + name + "\"");
    if (at == std::string::npos) return {};
    const std::size_t offset = std::stoul(text.substr(text.find("offset=\"", at) + 8));
    const char* block = text.data() + text.find('_', text.find("<AppendedData")) + 1 + offset;
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, block, sizeof bytes);
    std::vector<T> out(bytes / sizeof(T));
    std::memcpy(out.data(), block + sizeof bytes, bytes);
    return out;
  }
  std::string text;
};

class SurfaceFrames : public KeptRun {
 protected:
  // A press of 3 mm onto the middle of the block's top in 90 ticks, and up again.
  static Outcome replay(const std::string& more) {
    std::ofstream csv(path("press.csv"));
    csv << "t_s,x_m,y_m,z_m\n";
    for (int i = 0; i <= 100; ++i)
      csv << i * 1e-3 << ",0.04,0.04," << 0.0305 - 0.0035 * std::min(1.0, i / 90.0) << '\n';
    csv.close();
    return palpate(*folder_, "replay out/asset.palp press.csv -o forces.csv " + more);
  }
};

TEST_F(SurfaceFrames, show_the_dent_and_the_tool_at_every_so_many_ticks) {
  const Outcome outcome = replay("--surface frames --every 10 --json");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out).at("frames"), 11);
  const std::string series = content_of(path("frames/path.pvd"));
  for (int i = 0; i <= 10; ++i) {
    const std::string number = "0000" + std::string(i < 10 ? "0" : "") + std::to_string(i);
    EXPECT_TRUE(holds(series, "file=\"surface_" + number + ".vtu\"")) << i;
    const Vtu surface(path("frames/surface_" + number + ".vtu"));
    EXPECT_NEAR(surface.values<double>("TimeValue").at(0), i * 0.01, 1e-12);
    const auto tip = surface.values<double>("tool_position_m");
    EXPECT_EQ(Vtu(path("frames/tool_" + number + ".vtu")).values<double>("Points"), tip);
    const auto moved = surface.values<float>("displacement_m");
    const auto places = surface.values<double>("Points");
    ASSERT_EQ(moved.size(), places.size());
    // The deepest vertex follows the tool, and what is drawn is rest plus displacement: the top
    // was flat at 30 mm.
    float lowest = 0;
    for (std::size_t v = 2; v < moved.size(); v += 3) {
      lowest = std::min(lowest, moved[v]);
      EXPECT_LE(places[v] - double(moved[v]), 0.03 + 1e-6);
    }
    const double depth_m = std::max(0.0, 0.03 - tip.at(2));
    EXPECT_NEAR(-lowest, depth_m, 0.15 * depth_m + 1e-6) << i;
    const double force_N = surface.values<double>("force_on_tool_N").at(2);
    EXPECT_EQ(force_N > 0, depth_m > 1e-5) << i;
  }
}

TEST_F(SurfaceFrames, need_an_asset_that_says_how_it_moves_and_no_clock) {
  EXPECT_TRUE(holds(replay("--surface f --every 0").err, "--every: "));
  const Outcome live = replay("--surface f --realtime 0 --every 5");
  EXPECT_EQ(live.status, 0) << live.err;
  const Outcome clock = replay("--surface g --realtime 1000");
  EXPECT_EQ(clock.status, 1);
  EXPECT_TRUE(holds(clock.err, "frames are not written in real time"));
  EXPECT_FALSE(fs::exists(path("g")));
  const std::string golden = PALPATE_SOURCE_DIR "/tests/libfit/runtime/golden/version_1.palp";
  const Outcome still = palpate(*folder_, "replay " + golden + " press.csv -o n.csv --surface h");
  EXPECT_EQ(still.status, 1);
  EXPECT_TRUE(holds(still.err, "does not say how its surface moves"));
}

}  // namespace
}  // namespace palpate::tools
