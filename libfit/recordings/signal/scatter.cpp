#include "libfit/recordings/signal/scatter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "libfit/core/statistics.hpp"

namespace palpate::recordings {
namespace {

constexpr double kMedianOfNormal = 0.6745;  // of absolute values, in deviations
constexpr double kSame = 1e-9;              // of the range
constexpr double kRepeats = 0.4;            // of the readings, noise of one step repeats 0.27
constexpr double kOutlier = 5;              // deviations; a normal one is so large in 2 million
constexpr std::size_t kMinTrimmed = 8;

}  // namespace

double neighbour_scatter(const Eigen::VectorXd& values) {
  std::vector<double> bent;
  for (Eigen::Index i = 1; i + 1 < values.size(); ++i)
    bent.push_back(std::abs(values[i - 1] - 2 * values[i] + values[i + 1]));
  if (bent.empty()) return 0;
  return upper_median(std::move(bent)) / kMedianOfNormal / std::sqrt(6.0);
}

double quantum_of(const Eigen::VectorXd& values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i] - sorted[i - 1] > kSame * (sorted.back() - sorted.front()))
      least = std::min(least, sorted[i] - sorted[i - 1]);
  const Eigen::Index n = values.size();
  const auto repeats = (values.tail(n - 1).array() == values.head(n - 1).array()).count();
  return static_cast<double>(repeats) > kRepeats * static_cast<double>(n) && std::isfinite(least)
             ? least
             : 0;
}

namespace {

Line least_squares(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const double mx = x.mean(), my = y.mean();
  const Eigen::ArrayXd dx = x.array() - mx, dy = y.array() - my;
  Line line;
  const double xx = dx.square().sum();
  line.slope = xx > 0 ? (dx * dy).sum() / xx : 0;
  line.at_0 = my - line.slope * mx;
  const Eigen::ArrayXd left = dy - line.slope * dx;
  const double squares = left.square().sum();
  const auto n = static_cast<double>(x.size());
  line.deviation = n > 2 ? std::sqrt(squares / (n - 2)) : 0;
  if (squares > 0 && x.size() > 2)
    line.correlation = (left.head(x.size() - 1) * left.tail(x.size() - 1)).sum() / squares;
  return line;
}

}  // namespace

Line fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const Line line = least_squares(x, y);
  const Eigen::ArrayXd off = (y.array() - line.at_0 - line.slope * x.array()).abs();
  if (static_cast<std::size_t>(off.size()) < kMinTrimmed) return line;
  const double most = kOutlier * upper_median({off.begin(), off.end()}) / kMedianOfNormal;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < off.size(); ++i)
    if (off[i] <= most) kept.push_back(i);
  return static_cast<Eigen::Index>(kept.size()) < off.size() ? least_squares(x(kept), y(kept))
                                                             : line;
}

}  // namespace palpate::recordings
