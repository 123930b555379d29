#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"

namespace palpate::tools {
namespace {

constexpr int kPieces[] = {1, 2, 3, 4, 6, 8, 12};

struct CurveCost {
  int degree = 0, pieces = 0;
  std::size_t bytes = 0;  // of a node
  FamilyEvidence held_out;
  double p95_residual = 0;
};

std::size_t bytes_of_node(const CurveSet& curves) {
  Eigen::Index controls = 0;
  for (const Controls& control : curves.control) controls += control.cols();
  return static_cast<std::size_t>(controls) * sizeof(float);
}

CurveCost measure(const Samples& samples, CurveFamily family, int degree, int pieces, int jobs) {
  FitOptions options{.family = family, .judges_family = true, .degree = degree};
  options.pieces = {pieces, pieces, pieces};
  options.jobs = jobs;
  FitReport report;
  const FittedCurves fitted = fit_curves(samples, options, {}, &report);
  return {degree, pieces, bytes_of_node(fitted.curves), report.family.evidence.front(),
          report.error.p95};
}

void write_table(const std::filesystem::path& path, const std::string& family,
                 const std::vector<CurveCost>& lines) {
  static constexpr std::string_view kHeader[] = {
      "family",          "degree",       "pieces",      "bytes_per_node",
      "held_out_median", "held_out_p95", "residual_p95"};
  CsvWriter csv(path, kHeader);
  for (const CurveCost& line : lines)
    csv.text(family)
        .integer(line.degree)
        .integer(line.pieces)
        .integer(static_cast<std::int64_t>(line.bytes))
        .number(line.held_out.median_error)
        .number(line.held_out.p95_error)
        .number(line.p95_residual)
        .end_row();
  csv.commit();
}

// Median error of rows held out against bytes, both logarithmic, a line for each degree.
void write_picture(const std::filesystem::path& path, const std::string& title,
                   const std::vector<CurveCost>& lines) {
  constexpr double kWide = 560, kHigh = 340, kEdge = 60;
  double low = 1, high = 0, most = 0;
  for (const CurveCost& line : lines) {
    low = std::min(low, line.held_out.median_error);
    high = std::max(high, line.held_out.median_error);
    most = std::max(most, double(line.bytes));
  }
  const double least = double(lines.front().bytes);
  low = std::max(low / 1.2, 1e-9), high = std::max(1.2 * high, 2 * low);
  const auto x_of = [&](double bytes) {
    return kEdge + (kWide - 150) * std::log(bytes / least) / std::log(std::max(most / least, 2.0));
  };
  const auto y_of = [&](double error) {
    return kHigh - kEdge -
           (kHigh - 2 * kEdge) * std::log(std::max(error, low) / low) / std::log(high / low);
  };
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{}' height='{}' font-family='sans-serif' "
      "font-size='11'><text x='{}' y='20'>{}</text><text x='{}' y='{}'>bytes of a node</text>\n",
      kWide, kHigh, kEdge, title, kEdge, kHigh - 12);
  for (const double error : {low * 1.2, std::sqrt(low * high), high / 1.2})
    svg += fmt::format("<text x='{}' y='{:.0f}' text-anchor='end'>{:.2g} %</text>\n", kEdge - 6,
                       y_of(error) + 4, 100 * error);
  for (const double bytes : {least, std::sqrt(least * most), most})
    svg += fmt::format("<text x='{:.0f}' y='{}' text-anchor='middle'>{:.0f}</text>\n", x_of(bytes),
                       kHigh - 32, bytes);
  constexpr std::string_view kColours[] = {"#888", "#06c", "#c40", "#080"};
  for (int degree = 1; degree <= 4; ++degree) {
    std::string way;
    double x = 0, y = 0;
    for (const CurveCost& line : lines)
      if (line.degree == degree) {
        x = x_of(double(line.bytes)), y = y_of(line.held_out.median_error);
        way += fmt::format("{:.1f},{:.1f} ", x, y);
      }
    const std::string_view colour = kColours[degree - 1];
    svg += fmt::format(
        "<polyline points='{}' fill='none' stroke='{}' stroke-width='2'/>\n"
        "<text x='{:.0f}' y='{:.0f}' fill='{}'>degree {}</text>\n",
        way, colour, x + 6, y + 4, colour, degree);
  }
  write_file_atomically(path, svg + "</svg>\n");
}

}  // namespace

void bench_curves(const BenchRequest& request) {
  if (request.samples.empty())
    throw Error("bench curves", "there are no samples to fit", "Give --samples samples.h5.");
  const Samples samples = read_samples(request.samples);
  FitReport chosen;
  FitOptions automatic;
  automatic.jobs = request.jobs;
  fit_curves(samples, automatic, {}, &chosen);
  const CurveFamily family = chosen.family.family;
  const std::string name(kCurveFamilyNames[static_cast<std::size_t>(family)].name);
  say("{} points, {} rows; family {}: {}", samples.points(), samples.rows(), name,
      chosen.family.reason);
  std::vector<CurveCost> lines;
  for (int degree = 1; degree <= 4; ++degree)
    for (const int pieces : kPieces) {
      if (request.is_quick && pieces > 2) break;
      lines.push_back(measure(samples, family, degree, pieces, request.jobs));
      const CurveCost& line = lines.back();
      say("degree {}, {:2} pieces: {:4} bytes a node, held out {:.2f} % median, {:.2f} "
          "% p95; residual p95 {:.2f} %",
          degree, pieces, line.bytes, 100 * line.held_out.median_error,
          100 * line.held_out.p95_error, 100 * line.p95_residual);
    }
  const std::string stem =
      "curves_" + (request.part.empty() ? request.samples.stem().string() : request.part);
  write_table(request.folder / (stem + ".csv"), name, lines);
  write_picture(request.folder / (stem + ".svg"),
                stem.substr(7) + ", " + name + ": median error of rows held out", lines);
  say("wrote {} and {}.svg", (request.folder / (stem + ".csv")).string(), stem);
}

}  // namespace palpate::tools
