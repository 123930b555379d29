#include <fmt/core.h>

#include <tuple>

#include "libfit/core/body.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/runtime/tool/tool.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/bench/tick_flops.hpp"
#include "tools/workshop/bench/tick_timing.hpp"
#include "tools/workshop/rivals/finger_proxy.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kWarmTicks = 50000, kColdTicks = 100;

struct TickTime {
  int nodes;
  std::string_view law, kind, what, cache;
  TickSpread spread;
};

volatile double kept;  // so that no tick is optimized away
volatile unsigned kept_byte;

// All kinds on one body of one law: engine, finger proxy, and the floors of reading the bytes and
// of doing the arithmetic.
void measure_body(const Model& model, std::string_view law, bool is_quick,
                  std::vector<TickTime>& lines) {
  const BenchAsset body = make_bench_asset(model);
  const runtime::Asset& asset = body.asset;
  const double overhead_ns = clock_ns();
  CacheFlush flush;
  for (const TickKind& kind : kTicksOfKind)
    for (const bool is_cold : {false, true}) {
      const std::size_t ticks = (is_cold ? kColdTicks : kWarmTicks) / (is_quick ? 10U : 1U);
      const auto measure = [&](std::string_view what, auto tick) {
        lines.push_back(
            {asset.vertices, law, kind.name, what, is_cold ? "cold" : "warm",
             spread_of(time_ticks(kind, ticks, is_cold ? &flush : nullptr, overhead_ns, tick))});
      };
      runtime::Contact contact;
      runtime::Output out;
      const Vec3 outside = kind.tip(0) * 1.2;
      runtime::touch(asset, contact, outside.data(), out, nullptr, runtime::kCheckTick_s);
      measure("engine", [&](const Vec3& tip) {
        runtime::touch(asset, contact, tip.data(), out, nullptr, runtime::kCheckTick_s);
        kept = out.force_on_tool_N[0];
      });
      if (kind.name == "touch") {
        constexpr double kBall_m = 0.004;
        runtime::Contact ball;
        measure("a ball in the air", [&](const Vec3& tip) {
          Vec3 centre = tip;
          centre.head<2>() += kBall_m * tip.head<2>().normalized();
          runtime::touch_ball(asset, ball, centre.data(), kBall_m, out, nullptr,
                              runtime::kCheckTick_s);
          kept = out.force_on_tool_N[0];
        });
      }
      FingerProxy proxy(asset, 400, 0.3);
      proxy.tick(outside.data());
      measure("finger proxy", [&](const Vec3& tip) { kept = proxy.tick(tip.data()).x; });
      if (contact.triangle < 0) continue;
      const auto needed = lines_of_a_tick(asset, contact);
      measure("reading its bytes", [&](const Vec3&) {
        unsigned sum = 0;
        for (const unsigned char* line : needed) sum += *line;
        kept_byte = sum;
      });
      if (is_cold || out.state != runtime::ContactState::stick) continue;
      const long flops = flops_of_a_tick(asset, contact, kind.tip(300).data());
      measure("doing its arithmetic", [&](const Vec3&) { kept = do_flops(flops); });
    }
  say("{} nodes, {} triangles, {}, {:.1f} MB done", asset.vertices, asset.triangles, law,
      1e-6 * double(asset.file.bytes));
}

// The bench body as one that sways, that relaxes, or whose contacts move each other.
struct Compliant {
  std::string_view name;
  bool sways, relaxes, couples;
};
constexpr Compliant kCompliant[] = {{"stands", false, false, false},
                                    {"sways", true, false, false},
                                    {"sways, relaxes", true, true, false},
                                    {"couples", false, false, true},
                                    {"couples, sways", true, false, true}};

Model compliant(Model model, const Compliant& what) {
  if (what.sways) {
    auto& sway = model.curves.control[runtime::kSway];
    for (Eigen::Index v = 0; v < sway.rows(); ++v)
      sway.row(v) << 0.012, 0.02, 0.004, 0.003, -0.001, 0.002;
    sway = rounded_to_float(sway);
  }
  if (what.relaxes) {
    model.curves.relaxation.share = Eigen::Vector2d(0.5, 0.3);
    model.curves.relaxation.time_s = Eigen::Vector2d(0.02, 0.4);
  }
  if (what.couples) {
    model.curves.coupling.length_m = 0.003;
    for (int k = 0; k < 3; ++k) model.curves.coupling.isotropic_m_N[k] = 2e-4;
  }
  return model;
}

runtime::Tool row_of_balls(int balls, double radius_m) {
  runtime::Tool tool;
  tool.shape.balls = balls;
  for (int i = 0; i < balls; ++i) {
    tool.shape.ball[i].centre_m[2] = 0.003 * (i - 0.5 * (balls - 1));
    tool.shape.ball[i].radius_m = radius_m;
  }
  return tool;
}

// One ball, a tool of six and four tools of one, held and sliding, by what gives under them.
void measure_tools(bool is_quick, std::vector<TickTime>& lines) {
  constexpr double kRadius_m = 0.005;
  const double overhead_ns = clock_ns();
  const std::size_t ticks = kWarmTicks / (is_quick ? 10U : 1U);
  for (const Compliant& what : kCompliant) {
    Model model = compliant(with_family(bench_cylinder(150, 66), CurveFamily::rings), what);
    model.probe = sphere_spec(kRadius_m, 0.3);
    const BenchAsset body = make_bench_asset(model);
    for (const auto& [tools, balls, name] :
         {std::tuple{1, 1, "ball"}, std::tuple{1, 6, "tool of six balls"},
          std::tuple{4, 1, "four tools"}}) {
      if (tools * balls > 1 && !what.couples) continue;
      for (const TickKind& kind : kTicksOfKind) {
        std::vector<runtime::Tool> state(static_cast<std::size_t>(tools),
                                         row_of_balls(balls, kRadius_m));
        std::vector<runtime::Tool*> each;
        for (runtime::Tool& tool : state) each.push_back(&tool);
        std::vector<runtime::ToolInput> in(state.size());
        std::vector<runtime::ToolOutput> out(state.size());
        std::vector<runtime::Status> status(state.size());
        const auto tick = [&](const Vec3& tip) {
          const Vec3 centre = tip + kRadius_m * Vec3(tip.x(), tip.y(), 0).normalized();
          for (std::size_t i = 0; i < in.size(); ++i) {
            Eigen::Map<Vec3>(in[i].pose.position_m) = centre + 0.004 * double(i) * Vec3::UnitZ();
            in[i].dt_s = runtime::kCheckTick_s;
          }
          touch_tools(body.asset, each.data(), in.data(), out.data(), status.data(), tools);
          kept = out[0].force_on_tool_N[0];
        };
        tick(kind.tip(0) * 1.2);
        lines.push_back({body.asset.vertices, what.name, kind.name, name, "warm",
                         spread_of(time_ticks(kind, ticks, nullptr, overhead_ns, tick))});
      }
    }
  }
}

void write_table(const std::filesystem::path& path, const std::vector<TickTime>& lines) {
  static constexpr std::string_view kHeader[] = {"nodes",    "law",       "kind",   "what",
                                                 "cache",    "median_ns", "p99_ns", "p999_ns",
                                                 "worst_ns", "machine"};
  CsvWriter csv(path, kHeader);
  const std::string processor = machine();
  for (const TickTime& line : lines)
    csv.integer(line.nodes)
        .text(line.law)
        .text(line.kind)
        .text(line.what)
        .text(line.cache)
        .number(line.spread.median_ns)
        .number(line.spread.p99_ns)
        .number(line.spread.p999_ns)
        .number(line.spread.worst_ns)
        .text(processor)
        .end_row();
  csv.commit();
}

}  // namespace

void bench_tick(const BenchRequest& request) {
  struct AssetSize {
    int around, along, pieces;
  };
  // 250 to a million nodes; the largest with fewer pieces, so that it fits into 1 GB while it is
  // made.
  static constexpr AssetSize kSizes[] = {
      {25, 9, 12}, {75, 32, 12}, {150, 66, 12}, {480, 208, 12}, {1500, 666, 4}};
  std::vector<TickTime> lines;
  const std::size_t sizes = request.is_quick ? 2 : std::size(kSizes);
  for (std::size_t i = 0; i < sizes; ++i)
    for (const CurveFamilyName& row : kCurveFamilyNames) {
      // Proxy and floors need one law; the largest bodies take it alone.
      if (i > 2 && row.family != CurveFamily::rings) continue;
      measure_body(with_family(bench_cylinder(kSizes[i].around, kSizes[i].along, kSizes[i].pieces),
                               row.family),
                   row.name, request.is_quick, lines);
    }
  measure_tools(request.is_quick, lines);
  say("{:>8} {:14} {:6} {:20} {:5} {:>9} {:>9} {:>9} {:>9}", "nodes", "law", "kind", "what",
      "cache", "median", "p99", "p99.9", "worst ns");
  for (const TickTime& line : lines)
    say("{:8} {:14} {:6} {:20} {:5} {:9.0f} {:9.0f} {:9.0f} {:9.0f}", line.nodes, line.law,
        line.kind, line.what, line.cache, line.spread.median_ns, line.spread.p99_ns,
        line.spread.p999_ns, line.spread.worst_ns);
  write_table(request.folder / "tick.csv", lines);
  say("wrote {}", (request.folder / "tick.csv").string());
}

}  // namespace palpate::tools
