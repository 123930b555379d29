#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "libfit/io/csv.hpp"
#include "tools/bench.hpp"
#include "tools/console.hpp"
#include "tools/finger_proxy.hpp"
#include "tools/tick_work.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kWarmTicks = 50000, kColdTicks = 100;
constexpr std::size_t kFlushBytes = std::size_t{32} << 20;  // larger than the caches of a core

double now_ns() {
  return static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::steady_clock::now().time_since_epoch())
                                 .count());
}

struct Spread {
  double median_ns = 0, p99_ns = 0, p999_ns = 0, worst_ns = 0;
};

Spread spread_of(std::vector<double> ns) {
  std::sort(ns.begin(), ns.end());
  const auto at = [&](double share) {
    return ns[static_cast<std::size_t>(share * static_cast<double>(ns.size() - 1))];
  };
  return {at(0.5), at(0.99), at(0.999), ns.back()};
}

// What two looks at the clock take; taken off every measured tick.
double clock_ns() {
  std::vector<double> ns;
  for (int i = 0; i < 10000; ++i) {
    const double started = now_ns();
    ns.push_back(now_ns() - started);
  }
  return spread_of(ns).median_ns;
}

// Writes over a block larger than the caches, so that the next tick finds nothing in them.
class CacheFlush {
 public:
  void operator()() {
    for (std::size_t i = 0; i < block_.size(); i += 64)
      block_[i] = static_cast<unsigned char>(++round_);
  }

 private:
  std::vector<unsigned char> block_ = std::vector<unsigned char>(kFlushBytes);
  unsigned round_ = 0;
};

// Times `tick(tip)` one by one along a kind's way, as a force thread would call it.
template <class Tick>
Spread time_ticks(const TickKind& kind, std::size_t ticks, CacheFlush* flush, double overhead_ns,
                  Tick tick) {
  std::vector<double> ns;
  ns.reserve(ticks);
  const long first = 300;  // begins in contact, as a warm loop does
  for (long i = 0; i < first; ++i) tick(kind.tip(i));
  for (std::size_t i = 0; i < ticks; ++i) {
    const Vec3 tip = kind.tip(first + static_cast<long>(i));
    if (flush != nullptr) (*flush)();
    const double started = now_ns();
    tick(tip);
    ns.push_back(std::max(0.0, now_ns() - started - overhead_ns));
  }
  return spread_of(std::move(ns));
}

struct Line {
  int nodes;
  std::string_view kind, what, cache;
  Spread spread;
};

volatile double kept;  // so that no tick is optimized away
volatile unsigned kept_byte;

// All kinds on one body: engine, finger proxy, and the floor of reading the bytes.
void measure_body(int around, int along, int pieces, bool is_quick, std::vector<Line>& lines) {
  const BenchAsset body = make_bench_asset(bench_cylinder(around, along, pieces));
  const runtime::Asset& asset = body.asset;
  const double overhead_ns = clock_ns();
  CacheFlush flush;
  for (const TickKind& kind : kTicksOfKind)
    for (const bool is_cold : {false, true}) {
      const std::size_t ticks = (is_cold ? kColdTicks : kWarmTicks) / (is_quick ? 10U : 1U);
      CacheFlush* flusher = is_cold ? &flush : nullptr;
      const std::string_view cache = is_cold ? "cold" : "warm";
      runtime::Contact contact;
      runtime::Output out;
      const Vec3 outside = kind.tip(0) * 1.2;
      runtime::touch(asset, contact, outside.data(), out);
      lines.push_back({asset.vertices, kind.name, "engine", cache,
                       time_ticks(kind, ticks, flusher, overhead_ns, [&](const Vec3& tip) {
                         runtime::touch(asset, contact, tip.data(), out);
                         kept = out.force_on_tool_N[0];
                       })});
      FingerProxy proxy(asset, 400, 0.3);
      proxy.tick(outside.data());
      lines.push_back({asset.vertices, kind.name, "finger proxy", cache,
                       time_ticks(kind, ticks, flusher, overhead_ns,
                                  [&](const Vec3& tip) { kept = proxy.tick(tip.data()).x; })});
      if (contact.triangle < 0) continue;
      const auto needed = lines_of_a_tick(asset, contact);
      lines.push_back({asset.vertices, kind.name, "reading its bytes", cache,
                       time_ticks(kind, ticks, flusher, overhead_ns, [&](const Vec3&) {
                         unsigned sum = 0;
                         for (const unsigned char* line : needed) sum += *line;
                         kept_byte = sum;
                       })});
    }
  say("{} nodes, {} triangles, {:.1f} MB done", asset.vertices, asset.triangles,
      1e-6 * double(asset.file_bytes));
}

std::string machine() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

void write_table(const std::filesystem::path& path, const std::vector<Line>& lines) {
  static constexpr std::string_view kHeader[] = {
      "nodes", "kind", "what", "cache", "median_ns", "p99_ns", "p999_ns", "worst_ns", "machine"};
  CsvWriter csv(path, kHeader);
  const std::string processor = machine();
  for (const Line& line : lines)
    csv.integer(line.nodes)
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
  struct Size {
    int around, along, pieces;
  };
  // 250 to a million nodes; the largest with fewer pieces, so that it fits into 1 GB while it is
  // made.
  static constexpr Size kSizes[] = {
      {25, 9, 12}, {75, 32, 12}, {150, 66, 12}, {480, 208, 12}, {1500, 666, 4}};
  std::vector<Line> lines;
  const std::size_t sizes = request.is_quick ? 2 : std::size(kSizes);
  for (std::size_t i = 0; i < sizes; ++i)
    measure_body(kSizes[i].around, kSizes[i].along, kSizes[i].pieces, request.is_quick, lines);
  say("{:>8} {:6} {:18} {:5} {:>9} {:>9} {:>9} {:>9}", "nodes", "kind", "what", "cache", "median",
      "p99", "p99.9", "worst ns");
  for (const Line& line : lines)
    say("{:8} {:6} {:18} {:5} {:9.0f} {:9.0f} {:9.0f} {:9.0f}", line.nodes, line.kind, line.what,
        line.cache, line.spread.median_ns, line.spread.p99_ns, line.spread.p999_ns,
        line.spread.worst_ns);
  write_table(request.folder / "tick.csv", lines);
  say("wrote {}", (request.folder / "tick.csv").string());
}

}  // namespace palpate::tools
