#include "libfit/fit/rows/rows.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "libfit/core/error.hpp"

namespace palpate::fit {
namespace {

constexpr double kTangentialShare = 1e-6;  // of the depth: rounding of a press along the normal

[[noreturn]] void refuse(const std::string& what) {
  throw Error("samples", what, "Write the samples again with `palpate simulate` or `import`.");
}

bool is_finite(const Samples& s, Eigen::Index row) {
  return s.deflection.row(row).allFinite() && s.force.row(row).allFinite() &&
         !std::isinf(s.force_error[row]) && !(s.force_error[row] < 0);
}

// Good rows of each point, finite or not. Fills experiments with SI numbers; weights come later.
struct GoodRows {
  std::size_t all = 0, not_finite = 0;
};
std::vector<GoodRows> sort_rows(const Samples& s, BodyData& body) {
  std::vector<Eigen::Index> order(s.rows());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto key = [&](Eigen::Index i) {
    return std::array{s.point[i], s.experiment[i], s.step[i]};
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return key(a) < key(b); });

  std::vector<GoodRows> counts(body.points.size());
  std::int32_t experiment = -1, point = -1;
  bool is_cut = false;
  for (const Eigen::Index i : order) {
    const std::int32_t p = s.point[i];
    auto& experiments = body.points[p].experiments;
    ReportedRows& rows = body.points[p].rows;
    if (s.point[i] != point || s.experiment[i] != experiment) {
      point = s.point[i], experiment = s.experiment[i], is_cut = false;
      PointExperiment& begun = experiments.emplace_back();
      begun.id = experiment, begun.kind = s.kind[i];
    }
    const bool is_good = s.status[i] == RowStatus::good;
    const bool is_number = is_finite(s, i);
    counts[p].all += is_good;
    counts[p].not_finite += is_good && !is_number;
    if (is_cut) {
      ++rows.cut;
    } else if (!is_good || !is_number) {
      ++(is_good ? rows.not_finite : rows.not_good);
      is_cut = s.kind[i] != ExperimentKind::press;
    } else {
      experiments.back().deflection.emplace_back(s.deflection.row(i));
      experiments.back().force.emplace_back(s.force.row(i));
      experiments.back().row.push_back(i);
      ++rows.used;
    }
  }
  return counts;
}

// Subtracts the sway from the deflections.
void subtract_sway(PointData& point) {
  for (PointExperiment& e : point.experiments) {
    for (const Vec3& force : e.force) e.sway.push_back(point.sway * force);
    for (std::size_t i = 0; i < e.sway.size(); ++i) e.deflection[i] -= e.sway[i];
  }
}

// Scatter of the normal force about a line through its two neighbours in each experiment.
double scatter_N(const PointData& point) {
  std::vector<double> sizes;
  for (const PointExperiment& e : point.experiments) {
    for (std::size_t i = 1; i + 1 < e.row.size(); ++i) {
      const double before = (e.deflection[i] - e.deflection[i - 1]).norm();
      const double after = (e.deflection[i + 1] - e.deflection[i]).norm();
      if (!(before + after > 0)) continue;
      const double t = before / (before + after);
      const Vec3 second_difference = e.force[i] - (1 - t) * e.force[i - 1] - t * e.force[i + 1];
      sizes.push_back(std::abs(second_difference.dot(point.inward)) /
                      std::sqrt(1 + t * t + (1 - t) * (1 - t)));
    }
  }
  return robust_deviation(std::move(sizes));
}

double typical_force_N(const PointData& point) {
  std::vector<double> sizes;
  for (const PointExperiment& e : point.experiments)
    for (const Vec3& f : e.force) sizes.push_back(f.norm());
  return lower_quantile(std::move(sizes), 0.95);
}

std::vector<double> known_errors(const Samples& s, const PointData& point) {
  std::vector<double> errors;
  for (const PointExperiment& e : point.experiments)
    for (const Eigen::Index i : e.row)
      if (std::isfinite(s.force_error[i])) errors.push_back(s.force_error[i]);
  return errors;
}

// Empty when curves can be fitted; else what keeps them from it.
std::string find_problem(const Samples& s, const PointData& point, const GoodRows& counts,
                         bool has_rows) {
  if (!has_rows) return "no row of any experiment at this point";
  if (counts.all == 0) return "no good row";
  if (double(counts.not_finite) > 0.2 * double(counts.all))  // the record is not trusted
    return std::to_string(counts.not_finite) + " of " + std::to_string(counts.all) +
           " good rows are not finite numbers";
  std::vector<double> toward;  // force along the push, of the rows in contact
  double largest_N = 0;
  for (const PointExperiment& e : point.experiments)
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      largest_N = std::max(largest_N, e.force[i].norm());
      if (depth_of(point, e.deflection[i]) > 0) toward.push_back(e.force[i].dot(point.inward));
    }
  if (toward.empty()) return "no row with the probe in the body";
  if (!(largest_N > 0)) return "every force is zero";
  const auto errors = known_errors(s, point);
  if (!errors.empty() && largest_N < 4 * median(errors))
    return "no contact: the largest force is within four force errors of zero";
  const double reach = *std::max_element(toward.begin(), toward.end());
  const double pull = -*std::min_element(toward.begin(), toward.end());
  if (pull > reach && median(toward) < 0)
    return "forces point out of the body: the recording's sign of force or depth is reversed";
  if (!(largest_N < std::numeric_limits<float>::max()) ||
      !(reach > std::numeric_limits<float>::min()))
    return "forces are beyond what single precision holds";
  return {};
}

void set_weights(const Samples& s, double body_error_N, PointData& point) {
  const auto errors = known_errors(s, point);
  point.has_errors = !errors.empty();
  const double unknown_N = !errors.empty()    ? median(errors)
                           : body_error_N > 0 ? body_error_N
                                              : scatter_N(point);
  const double floor_N = kWeightFloor * point.force_N;
  for (PointExperiment& e : point.experiments)
    for (const Eigen::Index i : e.row) {
      const double error_N = std::isnan(s.force_error[i]) ? unknown_N : s.force_error[i];
      e.weight.push_back(point.force_N / std::hypot(error_N, floor_N));
    }
}

void make_dimensionless(double length_m, PointData& point) {
  point.normal_gradient *= length_m;
  point.sway *= point.force_N / length_m;
  for (PointExperiment& e : point.experiments) {
    for (Vec3& d : e.deflection) d /= length_m;
    for (Vec3& d : e.sway) d /= length_m;
    for (Vec3& f : e.force) f /= point.force_N;
    double depth = 0, lateral = 0, of_tool = 0;
    for (std::size_t i = 0; i < e.deflection.size(); ++i) {
      const Vec3& d = e.deflection[i];
      depth = std::max(depth, depth_of(point, d));
      lateral = std::max(lateral, lateral_of(point, d).norm());
      of_tool = std::max(of_tool, lateral_of(point, e.tool_deflection(i)).norm());
    }
    point.depth = std::max(point.depth, depth);
    const bool is_press = e.kind == ExperimentKind::press;
    e.is_replayed = !is_press || lateral > kTangentialShare * depth;
    e.is_drag = !is_press || of_tool > kTangentialShare * depth;
  }
}

}  // namespace

void check_samples(const Samples& s) {
  const std::size_t rows = s.rows(), points = s.points();
  if (s.point.size() != rows || s.experiment.size() != rows || s.kind.size() != rows ||
      s.step.size() != rows || s.status.size() != rows || s.force.rows() != s.rows() ||
      s.force_error.size() != s.rows())
    refuse("row arrays differ in length");
  if (s.point_normal.rows() != s.points() || s.point_name.size() != points)
    refuse("point arrays differ in length");
  if (s.point_sway.rows() != 0 && s.point_sway.rows() != s.points())
    refuse("point_sway has neither no rows nor one per point");
  if (s.point_normal_gradient.rows() != 0 && s.point_normal_gradient.rows() != s.points())
    refuse("point_normal_gradient has neither no rows nor one per point");
  for (Eigen::Index p = 0; p < s.points(); ++p) {
    if (!s.point_position.row(p).allFinite() ||
        !(std::abs(s.point_normal.row(p).norm() - 1) < 1e-6))
      refuse("test point " + std::to_string(p) + " has no finite position and unit normal");
    if (s.point_normal_gradient.rows() != 0 && !s.point_normal_gradient.row(p).allFinite())
      refuse("test point " + std::to_string(p) + " has a normal gradient that is not finite");
  }
  std::map<std::int32_t, std::size_t> first;
  for (std::size_t i = 0; i < rows; ++i) {
    if (s.point[i] < 0 || s.point[i] >= s.points())
      refuse("row " + std::to_string(i) + " names test point " + std::to_string(s.point[i]) +
             " of " + std::to_string(points));
    const auto at = first.emplace(s.experiment[i], i).first->second;
    if (s.point[at] != s.point[i] || s.kind[at] != s.kind[i])
      refuse("experiment " + std::to_string(s.experiment[i]) + " mixes test points or kinds");
  }
}

Mat3 offset_gradient(const Samples& samples, Eigen::Index point) {
  if (samples.point_normal_gradient.rows() == 0) return Mat3::Zero();
  const Mat3 gradient = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      samples.point_normal_gradient.row(point).data());
  const double radius_m = ball_radius_m(samples.probe);
  if (!(radius_m > 0)) return gradient;
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(0.5 * (gradient + gradient.transpose()));
  const Vec3 own = principal.eigenvalues();
  // A hollow narrower than 1.4 times the ball's radius counts as that wide, for no offset surface
  // is left where the ball touches at its rim.
  const Vec3 offset = own.array() / (1 - radius_m * own.array()).max(0.3);
  return principal.eigenvectors() * offset.asDiagonal() * principal.eigenvectors().transpose();
}

BodyData gather_experiments(const Samples& samples, const std::vector<Mat3>& sways) {
  check_samples(samples);
  BodyData body;
  body.points.resize(samples.points());
  for (std::size_t p = 0; p < body.points.size(); ++p) {
    body.points[p].inward = samples.point_normal.row(p).transpose().normalized();
    body.points[p].normal_gradient = offset_gradient(samples, p);
  }
  const auto counts = sort_rows(samples, body);

  double deepest_m = 0;
  std::vector<double> errors_N;
  for (std::size_t p = 0; p < body.points.size(); ++p) {
    PointData& point = body.points[p];
    const bool has_rows = !point.experiments.empty();
    std::erase_if(point.experiments, [](const PointExperiment& e) { return e.row.empty(); });
    if (!sways.empty()) {
      point.sway = sways[p];
      subtract_sway(point);
    }
    point.problem = find_problem(samples, point, counts[p], has_rows);
    if (!point.problem.empty()) continue;
    point.force_N = typical_force_N(point);
    if (!(point.force_N > 0)) {
      point.problem = "nearly every force is zero";
      continue;
    }
    for (const PointExperiment& e : point.experiments)
      for (const Vec3& d : e.deflection)
        point.depth_m = std::max(point.depth_m, depth_of(point, d));
    deepest_m = std::max(deepest_m, point.depth_m);
    const auto errors = known_errors(samples, point);
    errors_N.insert(errors_N.end(), errors.begin(), errors.end());
  }
  if (deepest_m > 0) body.length_m = deepest_m;
  body.error_N = median(errors_N);
  for (PointData& point : body.points) {
    if (!point.problem.empty()) {
      point.rows.used = 0;
      point.experiments.clear();
      continue;
    }
    set_weights(samples, body.error_N, point);
    make_dimensionless(body.length_m, point);
  }
  return body;
}

}  // namespace palpate::fit
