#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <thread>

#include "libfem/solve/experiments/simulate.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/fem.hpp"

namespace palpate::tools {
namespace {

/// CPU time of each thread that looks whether it should stop, between its first and last look.
class ThreadClock {
 public:
  void look() {
    const double now = thread_cpu_s();
    const std::lock_guard<std::mutex> lock(mutex_);
    auto& [first, last] = seen_.try_emplace(std::this_thread::get_id(), now, now).first->second;
    first = std::min(first, now);
    last = std::max(last, now);
  }
  std::vector<double> seconds() const {
    std::vector<double> out;
    for (const auto& [thread, span] : seen_) out.push_back(span.second - span.first);
    return out;
  }

 private:
  std::mutex mutex_;
  std::map<std::thread::id, std::pair<double, double>> seen_;
};

TestPoints points_on_top(int count) {
  TestPoints points;
  points.position.resize(count, 3);
  points.normal.resize(count, 3);
  for (int p = 0; p < count; ++p) {
    points.position.row(p) << 0.032 + 0.0117 * (p % 4), 0.033 + 0.0123 * (p / 4), 0.04;
    points.normal.row(p) << 0, 0, -1;
    points.name.push_back(fmt::format("p{}", p + 1));
  }
  return points;
}

}  // namespace

BenchTable fem_threads(const BenchRequest& request) {
  FemCase what = fem_block(0.45);
  const fem::Simulator simulator(what.setup);
  const fem::Experiments press = press_of(0.005, 5);
  BenchTable table{{"points", "threads", "wall_s", "CPU_s", "CPU_of_busiest_s", "CPU_s_per_point",
                    "one_thread/busiest", "same_bits"},
                   {}};
  std::map<int, Samples> alone;
  std::map<int, double> alone_s;
  const std::vector<int> counts = request.is_quick ? std::vector{2} : std::vector{1, 4, 16};
  for (const int threads : {1, 2})
    for (const int count : counts) {
      if (threads > count) continue;
      ThreadClock clock;
      Progress progress;
      progress.is_stopped = [&] {
        clock.look();
        return false;
      };
      progress.step = [&](std::size_t, std::size_t, const std::string&) { clock.look(); };
      const double start = wall_seconds();
      const Samples samples = fem::simulate(simulator, experiments_at(points_on_top(count)), press,
                                            {.jobs = threads, .already_done = {}}, {}, progress);
      const double wall_s = wall_seconds() - start;
      const std::vector<double> cpu = clock.seconds();
      double sum = 0, busiest = 0;
      for (const double s : cpu) {
        sum += s;
        busiest = std::max(busiest, s);
      }
      if (threads == 1) {
        alone[count] = samples;
        alone_s[count] = sum;
      }
      table.rows.push_back({fmt::format("{}", count), fmt::format("{}", cpu.size()),
                            fmt::format("{:.2f}", wall_s), fmt::format("{:.2f}", sum),
                            fmt::format("{:.2f}", busiest), fmt::format("{:.2f}", sum / count),
                            fmt::format("{:.2f}", alone_s[count] / busiest),
                            alone[count].force == samples.force ? "yes" : "no"});
    }
  return table;
}

}  // namespace palpate::tools
