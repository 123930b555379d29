#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr int kMeans = 400;
constexpr int kRounds = 30;
constexpr Eigen::Index kReach = 4;  // means on either side, over which a slope is taken
constexpr Eigen::Index kLeastMeans = 40;
constexpr double kFreeShare = 0.1;  // of the travel, taken as free to start with
constexpr double kSettled = 1e-3;   // of its deviation, that a shift may still move
constexpr double kMaxCorrelation = 0.95;

// A repeat over the first one: its push is bias + scale * that of the first, shift earlier.
struct Overlay {
  PressCurve curve;
  double shift_m = 0, bias_N = 0, scale = 1, shift_deviation_m = 0;
};

// Travel at which a curve first has half of a rise.
double travel_at(const PressCurve& curve, double bias_N, double push_N) {
  Eigen::Index i = 1;
  while (i + 1 < curve.push_N.size() && curve.push_N[i] - bias_N < push_N) ++i;
  const double before = curve.push_N[i - 1] - bias_N, after = curve.push_N[i] - bias_N;
  const double share =
      after > before ? std::clamp((push_N - before) / (after - before), 0., 1.) : 1;
  return curve.travel_m[i - 1] + share * (curve.travel_m[i] - curve.travel_m[i - 1]);
}

// All readings where the overlays put them, as far as all of them go.
PressCurve overlaid(const std::vector<Overlay>& overlays, const std::vector<WayIn>& ways) {
  double first_m = -1e300, last_m = 1e300;
  for (const Overlay& o : overlays) {
    first_m = std::max(first_m, o.curve.travel_m[0] - o.shift_m);
    last_m = std::min(last_m, o.curve.travel_m[o.curve.travel_m.size() - 1] - o.shift_m);
  }
  std::vector<double> travel, push;
  for (std::size_t k = 0; k < ways.size(); ++k)
    for (Eigen::Index i = 0; i < ways[k].travel_m.size(); ++i) {
      const double at_m = ways[k].travel_m[i] - overlays[k].shift_m;
      if (!(at_m >= first_m && at_m <= last_m)) continue;
      travel.push_back(at_m);
      push.push_back((ways[k].push_N[i] - overlays[k].bias_N) / overlays[k].scale);
    }
  if (travel.size() < static_cast<std::size_t>(kLeastMeans)) return {};
  const auto n = static_cast<Eigen::Index>(travel.size());
  return mean_curve(Eigen::Map<Eigen::VectorXd>(travel.data(), n),
                    Eigen::Map<Eigen::VectorXd>(push.data(), n), kMeans);
}

struct Line2 {
  double push_N = 0, slope_N_m = 0;
};

// Push and slope of a curve at a travel inside it: a line through the means around.
Line2 line_at(const PressCurve& curve, double at_m) {
  const Eigen::VectorXd& x = curve.travel_m;
  const Eigen::Index after = std::lower_bound(x.begin(), x.end(), at_m) - x.begin();
  const Eigen::Index begin = std::clamp<Eigen::Index>(after - kReach, 0, x.size() - 2 * kReach);
  const auto dx = x.segment(begin, 2 * kReach).array() - at_m;
  const auto y = curve.push_N.segment(begin, 2 * kReach).array();
  const double mean_x = dx.mean(), mean_y = y.mean();
  const double slope = ((dx - mean_x) * y).sum() / (dx - mean_x).square().sum();
  return {mean_y - slope * mean_x, slope};
}

// Moves an overlay by what takes its curve nearest to the common one, in the least squares sense.
// Returns how far the shift moved.
double settle(const PressCurve& common, Overlay& o) {
  std::vector<Vec3> row;
  std::vector<double> left;
  for (Eigen::Index i = 0; i < o.curve.travel_m.size(); ++i) {
    const double at_m = o.curve.travel_m[i] - o.shift_m;
    if (at_m < common.travel_m[kReach] ||
        at_m > common.travel_m[common.travel_m.size() - 1 - kReach])
      continue;
    const Line2 line = line_at(common, at_m);
    row.emplace_back(1, line.push_N, -line.slope_N_m);
    left.push_back((o.curve.push_N[i] - o.bias_N) / o.scale - line.push_N);
  }
  if (row.size() < static_cast<std::size_t>(kLeastMeans) / 2) return 0;
  Vec3 size = Vec3::Zero();
  for (const Vec3& r : row) size = size.cwiseMax(r.cwiseAbs());
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < row.size(); ++i) {
    const Vec3 r = row[i].cwiseQuotient(size);
    normal += r * r.transpose();
    right += left[i] * r;
  }
  const Eigen::LDLT<Mat3> factor(normal);
  const Vec3 step = factor.solve(right).cwiseQuotient(size);
  double squares = 0, together = 0, before = 0;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double now = left[i] - row[i].dot(step);
    squares += now * now;
    together += now * before;
    before = now;
  }
  const double r = std::clamp(together / std::max(squares, 1e-300), 0.0, kMaxCorrelation);
  o.shift_deviation_m = std::sqrt(factor.solve(Mat3::Identity())(2, 2) * squares /
                                  static_cast<double>(row.size() - 3) * (1 + r) / (1 - r)) /
                        size[2];
  o.bias_N += o.scale * step[0];
  o.scale *= 1 + step[1];
  o.shift_m += step[2];
  return std::abs(step[2]);
}

}  // namespace

std::vector<KnownContact> common_contacts(const std::vector<WayIn>& ways,
                                          const SignalSettings& settings) {
  std::vector<Overlay> overlays;
  double half_N = 1e300;
  for (const WayIn& way : ways) {
    Overlay o;
    o.curve = mean_curve(way.travel_m, way.push_N, kMeans);
    const Eigen::Index n = o.curve.push_N.size();
    if (n < kLeastMeans) return {};
    o.bias_N = o.curve.push_N.head(n / 10).mean();
    half_N = std::min(half_N, (o.curve.push_N.maxCoeff() - o.bias_N) / 2);
    overlays.push_back(std::move(o));
  }
  for (Overlay& o : overlays)
    o.shift_m = travel_at(o.curve, o.bias_N, half_N) -
                travel_at(overlays[0].curve, overlays[0].bias_N, half_N);
  PressCurve common;
  for (int round = 0; round < kRounds; ++round) {
    common = overlaid(overlays, ways);
    if (common.push_N.size() < kLeastMeans) return {};
    double largest = 0;
    for (Overlay& o : overlays) {
      const double moved_m = settle(common, o);
      largest = std::max(largest, moved_m / std::max(o.shift_deviation_m, 1e-300));
    }
    if (largest < kSettled) break;
  }
  common = overlaid(overlays, ways);
  const auto free =
      static_cast<Eigen::Index>(kFreeShare * static_cast<double>(common.push_N.size()));
  common.noise_N = fit_line(common.travel_m.head(free), common.push_N.head(free)).deviation;
  const ContactEstimate found =
      contact_estimator_named(settings.contact)->estimate(common, settings);
  if (found.begins_in_contact) return {};
  std::vector<KnownContact> contacts;
  for (const Overlay& o : overlays)
    contacts.push_back(
        {found.travel_m + o.shift_m, std::hypot(found.deviation_m, o.shift_deviation_m), "common"});
  return contacts;
}

}  // namespace palpate::recordings
