#include <fmt/core.h>

#include "libfit/io/csv/csv.hpp"
#include "libfit/runtime/tool/turning_tool.hpp"
#include "tools/bench/bench.hpp"
#include "tools/bench/finger_proxy.hpp"
#include "tools/bench/machine.hpp"
#include "tools/bench/tick_flops.hpp"
#include "tools/bench/tick_timing.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kWarmTicks = 50000, kColdTicks = 100;

struct TickTime {
  int nodes;
  std::string_view law, kind, what, cache;
  Spread spread;
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
      1e-6 * double(asset.file_bytes));
}

// A ball that turns on a body with curves at seven leans, beside the same ball on the same body
// that does not.
void measure_turning(bool is_quick, std::vector<TickTime>& lines) {
  Model model = with_family(bench_cylinder(25, 9), CurveFamily::rings);
  model.probe = sphere_spec(0.005, 0.3);
  LeanCurves leans;
  for (const double tilt_rad : {0.44, 0.87}) leans.sine.push_back(std::sin(tilt_rad));
  for (int node = 0; node < 7; ++node)
    leans.node.push_back({(0.7 + 0.1 * node) * model.curves.control[0],
                          model.curves.control[runtime::kSide2],
                          model.curves.control[runtime::kSide3]});
  const BenchAsset body = make_bench_asset(model, leans);
  const double overhead_ns = clock_ns(), radius_m = body.asset.probe_radius_m;
  const std::size_t ticks = kWarmTicks / (is_quick ? 10U : 1U);
  const auto centre = [&](const Vec3& tip) {
    return Vec3(tip + radius_m * Vec3(tip.x(), tip.y(), 0).normalized());
  };
  for (const TickKind& kind : kTicksOfKind) {
    const auto measure = [&](std::string_view what, auto tick) {
      tick(kind.tip(0) * 1.2);
      lines.push_back({body.asset.vertices, "rings", kind.name, what, "warm",
                       spread_of(time_ticks(kind, ticks, nullptr, overhead_ns, tick))});
    };
    runtime::Contact contact;
    measure("ball", [&](const Vec3& tip) {
      runtime::Output out;
      runtime::touch_ball(body.asset, contact, centre(tip).data(), radius_m, out);
      kept = out.force_on_tool_N[0];
    });
    for (const bool turns : {false, true}) {
      runtime::TurningContact turning;
      long k = 0;
      measure(turns ? "ball that turns" : "ball held leaning", [&](const Vec3& tip) {
        k += turns;
        const double angle = 0.6 + 0.2 * std::sin(1e-3 * double(k));
        const double pose[2] = {std::cos(0.5 * angle), std::sin(0.5 * angle)};
        runtime::Frame frame;
        make_frame({{0, 0, 0}, {pose[0], 0, pose[1], 0}}, frame);
        runtime::TurningOutput out;
        touch_turning(body.asset, turning, centre(tip).data(), frame, out);
        kept = out.torque_on_tool_Nm[0];
      });
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
  measure_turning(request.is_quick, lines);
  say("{:>8} {:9} {:6} {:20} {:5} {:>9} {:>9} {:>9} {:>9}", "nodes", "law", "kind", "what", "cache",
      "median", "p99", "p99.9", "worst ns");
  for (const TickTime& line : lines)
    say("{:8} {:9} {:6} {:20} {:5} {:9.0f} {:9.0f} {:9.0f} {:9.0f}", line.nodes, line.law,
        line.kind, line.what, line.cache, line.spread.median_ns, line.spread.p99_ns,
        line.spread.p999_ns, line.spread.worst_ns);
  write_table(request.folder / "tick.csv", lines);
  say("wrote {}", (request.folder / "tick.csv").string());
}

}  // namespace palpate::tools
