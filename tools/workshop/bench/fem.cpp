#include "tools/workshop/bench/fem.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "libfit/core/error.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

struct FemBench {
  std::string_view name, summary;
  BenchTable (*run)(const BenchRequest&);
};
constexpr FemBench kParts[] = {
    {"solver", "a press and a drag by solver choice, against a factor per iteration", fem_solver},
    {"uniform", "graded against uniform mesh of equal contact element size", fem_uniform},
    {"accuracy", "force error and time of a press by element, size and Poisson's ratio",
     fem_accuracy},
    {"speed", "force error against time of a press by mesh share, element and tolerance",
     fem_speed},
    {"bodies", "press and whole test point on block, cylinder and liver", fem_bodies},
    {"ripple", "force over 0.1 mm steps against a smooth curve", fem_ripple},
    {"threads", "cost by number of test points, one and two threads", fem_threads},
    {"rates", "factor and solve rates by number of nodes, beside dgemm and streaming read",
     fem_rates},
};

std::string part_names() {
  std::string out;
  for (const FemBench& part : kParts) out += (out.empty() ? "" : ", ") + std::string(part.name);
  return out;
}

}  // namespace

void show_table(const BenchTable& table, std::string_view name, const BenchRequest& request) {
  std::vector<std::size_t> width;
  for (std::size_t c = 0; c < table.header.size(); ++c) {
    width.push_back(table.header[c].size());
    for (const auto& row : table.rows) width[c] = std::max(width[c], row[c].size());
  }
  const auto print = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < row.size(); ++c)
      if (c == 0)
        fmt::print("{:<{}}", row[c], width[c]);
      else
        fmt::print("  {:>{}}", row[c], width[c]);
    fmt::print("\n");
  };
  print(table.header);
  for (const auto& row : table.rows) print(row);
  std::fflush(stdout);
  const std::vector<std::string_view> header(table.header.begin(), table.header.end());
  CsvWriter csv(request.folder / fmt::format("fem_{}.csv", name), header);
  for (const auto& row : table.rows) {
    for (const std::string& field : row) csv.text(field);
    csv.end_row();
  }
  csv.commit();
}

void bench_fem(const BenchRequest& request) {
  const bool is_all = request.part.empty();
  bool is_found = false;
  for (const FemBench& part : kParts) {
    if (!is_all && part.name != request.part) continue;
    is_found = true;
    say("{}: {}", part.name, part.summary);
    const double start = thread_cpu_s();
    show_table(part.run(request), part.name, request);
    say("  {:.0f} s of CPU of this thread", thread_cpu_s() - start);
  }
  if (!is_found)
    throw Error("bench fem --part", "there is no part called " + request.part,
                "Choose one of: " + part_names() + ".");
}

}  // namespace palpate::tools
