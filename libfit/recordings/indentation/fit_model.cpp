#include "libfit/recordings/indentation/fit_model.hpp"

#include <ceres/ceres.h>
#include <fmt/core.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"
#include "libfit/recordings/indentation/what_is_left.hpp"

namespace palpate::recordings {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kScanRows = 300;  // that trial contact points are compared on
constexpr int kScan = 64;
constexpr double kCloser = 1.25;  // depth of one trial over the next, towards the end
constexpr double kMisfit = 0.05;  // of the force: a model that leaves more does not describe it
constexpr double kLeastExponent = 0.7, kMostExponent = 6;
constexpr double kSame = 2;  // bic within which models are equals
constexpr Eigen::Index kLeastPressed = 3;
// Of a pattern in what is left: runs of one sign over the parts are 5 or fewer of 20 once in 200
// presses of white noise, and a share of the force below this moves no modulus by much.
constexpr int kMostRuns = 5;
constexpr double kLeastPattern = 0.003;
constexpr double kAboveNoise = 3;  // squares of parts over those of white noise
constexpr double kAboveWaves = 2;  // of what is left in parts of the free travel

double square(double x) { return x * x; }

// A curve in units of its range and rise; unknowns are contact, amplitude, level, and where asked
// for exponent and slope.
struct ModelProblem {
  Eigen::VectorXd x, y;
  double range_m = 1, rise_N = 1, first_m = 0, base_N = 0;
  ModelLaw law;  // empty: power law
  double area_scale = 1;
  bool has_slope = false;
  std::optional<double> contact;

  // ShapeValue at a scaled depth, 1 at about full depth; by depth and by exponent.
  struct ShapeValue {
    double value = 0, by_depth = 0, by_exponent = 0;
  };
  ShapeValue shape(double depth, double exponent) const {
    if (!(depth > 0)) return {};
    if (law) {
      const ModelForce f = law(depth * range_m);
      return {f.area_m2 / area_scale, f.slope_m * range_m / area_scale, 0};
    }
    const double value = std::pow(depth, exponent);
    return {value, exponent * value / depth, value * std::log(depth)};
  }
  Eigen::Index linear() const { return has_slope ? 3 : 2; }
  Eigen::Index unknowns() const { return linear() + (contact ? 0 : 1) + (law ? 0 : 1); }

  // Least squares in what is linear, at one contact point and exponent; every `stride`th row.
  double linear_squares(double at, double exponent, Eigen::Index stride, Vec3& found) const {
    Mat3 normal = Mat3::Identity();
    const Eigen::Index n = linear();
    normal.topLeftCorner(n, n).setZero();
    Vec3 right = Vec3::Zero();
    double all = 0;
    Eigen::Index pressed = 0;
    for (Eigen::Index i = 0; i < x.size(); i += stride) {
      const double s = shape(x[i] - at, exponent).value;
      if (!std::isfinite(s)) return kInfinity;
      const Vec3 row(s, 1, x[i]);
      normal.topLeftCorner(n, n) += row.head(n) * row.head(n).transpose();
      right.head(n) += y[i] * row.head(n);
      all += y[i] * y[i];
      pressed += s > 0;
    }
    if (pressed < kLeastPressed) return kInfinity;
    found = normal.ldlt().solve(right);
    return found[0] > 0 ? all - right.dot(found) : kInfinity;
  }
};

// All unknowns: contact, exponent, amplitude, level, slope.
using Unknowns = Eigen::Matrix<double, 5, 1>;

class Residuals final : public ceres::CostFunction {
 public:
  explicit Residuals(const ModelProblem& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.x.size()));
    mutable_parameter_block_sizes()->push_back(5);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* u = parameters[0];
    double* const jacobian = jacobians ? jacobians[0] : nullptr;
    for (Eigen::Index i = 0; i < problem_.x.size(); ++i) {
      const auto s = problem_.shape(problem_.x[i] - u[0], u[1]);
      if (!std::isfinite(s.value)) return false;
      residuals[i] = u[2] * s.value + u[3] + u[4] * problem_.x[i] - problem_.y[i];
      if (!jacobian) continue;
      double* row = jacobian + 5 * i;
      row[0] = -u[2] * s.by_depth, row[1] = u[2] * s.by_exponent, row[2] = s.value;
      row[3] = 1, row[4] = problem_.x[i];
    }
    return true;
  }

 private:
  const ModelProblem& problem_;
};

// Unknowns to start from: the best of trial contact points that lie denser towards the end, since a
// press may be a small part of the travel.
std::optional<Unknowns> start_of(const ModelProblem& p) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, p.x.size() / kScanRows);
  std::vector<double> trial;
  if (p.contact) {
    trial.push_back(*p.contact);
  } else {
    for (int k = 0; k < kScan; ++k) trial.push_back(-0.5 + 1.5 * k / kScan);
    for (double depth = 0.05; depth > 2. / static_cast<double>(p.x.size()); depth /= kCloser)
      trial.push_back(1 - depth);
  }
  std::vector<double> exponents{1.5};
  if (!p.law) exponents = {1, 1.5, 2, 3};
  Unknowns best = Unknowns::Zero();
  double least = kInfinity;
  // A small press has few of every so many rows: then all count.
  for (const Eigen::Index step : {stride, Eigen::Index{1}}) {
    for (const double contact : trial)
      for (const double exponent : exponents) {
        if (step == 1 && stride > 1 && contact < 0.9) continue;
        Vec3 found = Vec3::Zero();
        const double squares =
            p.linear_squares(contact, exponent, step, found) * static_cast<double>(step);
        if (squares < least) {
          least = squares;
          best << contact, exponent, found[0], found[1], p.has_slope ? found[2] : 0;
        }
      }
    if (stride == 1) break;
  }
  if (!std::isfinite(least)) return std::nullopt;
  return best;
}

// Whether what is left goes with depth: in few runs or by more than noise, and by more than the
// free part's own waves.
bool has_pattern(const ModelProblem& p, const PartMeans& pressed, const Eigen::VectorXd& left,
                 double noise, double contact, double force) {
  if ((pressed.count.array() > 0).count() < kParts || pressed.rms() < kLeastPattern * force)
    return false;
  const double squares = pressed.mean.cwiseAbs2().dot(pressed.count) / kParts;
  if (pressed.runs() > kMostRuns && squares < kAboveNoise * noise) return false;
  const double depth = p.x.maxCoeff() - contact;
  // As long a part of the free travel as the press is deep, or what there is of it.
  const PartMeans free = part_means(p.x, left, std::max(0., contact - depth), contact);
  return (free.count.array() > 0).count() < kParts / 2 || pressed.rms() > kAboveWaves * free.rms();
}

struct SolvedModel {
  ModelFit fit;
  double squares = 0, correlation_time = 1;
  Eigen::Index unknowns = 0;
};

std::optional<SolvedModel> solve(const ModelProblem& p, const IndentationModel& model,
                                 const Indentation& press) {
  auto start = start_of(p);
  if (!start) return std::nullopt;
  Unknowns u = *start;
  ceres::Problem problem;
  problem.AddResidualBlock(new Residuals(p), nullptr, u.data());
  std::vector<int> fixed;
  if (p.contact) fixed.push_back(0);
  if (p.law) fixed.push_back(1);
  if (!p.has_slope) fixed.push_back(4);
  problem.SetManifold(u.data(), new ceres::SubsetManifold(5, fixed));
  if (!p.law) {
    problem.SetParameterLowerBound(u.data(), 1, kLeastExponent);
    problem.SetParameterUpperBound(u.data(), 1, kMostExponent);
  }
  problem.SetParameterLowerBound(u.data(), 0, -3);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = options.parameter_tolerance = 1e-12;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !(u[2] > 0)) return std::nullopt;

  const Eigen::Index n = p.x.size();
  Eigen::VectorXd left(n);
  Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor> all(n, 5);
  double* jacobian = all.data();
  const double* at = u.data();
  if (!Residuals(p).Evaluate(&at, left.data(), &jacobian)) return std::nullopt;
  std::vector<Eigen::Index> free;
  for (int k = 0; k < 5; ++k)
    if (std::ranges::find(fixed, k) == fixed.end()) free.push_back(k);
  const Eigen::MatrixXd columns = all(Eigen::all, free);
  SolvedModel out;
  out.unknowns = static_cast<Eigen::Index>(free.size());
  out.squares = left.squaredNorm();
  out.correlation_time = correlation_time(left);
  const double variance =
      out.squares / static_cast<double>(n - out.unknowns) * out.correlation_time;
  const Eigen::MatrixXd covariance =
                            (columns.transpose() * columns)
                                .ldlt()
                                .solve(Eigen::MatrixXd::Identity(out.unknowns, out.unknowns)) *
                            variance,
                        drifting = covariance_of(columns, left);
  const auto deviation = [&](Eigen::Index k) {
    const auto place = std::ranges::find(free, k);
    return place == free.end()
               ? 0.
               : std::sqrt(std::max({0., covariance.diagonal()[place - free.begin()],
                                     drifting.diagonal()[place - free.begin()]}));
  };
  ModelFit& fit = out.fit;
  fit.model = &model;
  fit.contact_m = p.first_m + u[0] * p.range_m;
  fit.contact_deviation_m = deviation(0) * p.range_m;
  fit.baseline_N = p.base_N + (u[3] + u[4] * u[0]) * p.rise_N;
  fit.slope_N_m = u[4] * p.rise_N / p.range_m;
  fit.depth_m = (p.x.maxCoeff() - u[0]) * p.range_m;
  fit.force_N = u[2] * p.shape(p.x.maxCoeff() - u[0], u[1]).value * p.rise_N;
  const double per_young = (1 - square(press.poisson)) * p.rise_N / p.area_scale;
  fit.young_Pa = p.law ? u[2] * per_young : kNan;
  fit.young_deviation_Pa = p.law ? deviation(2) * per_young : kNan;
  if (!p.law) fit.exponent = u[1], fit.exponent_deviation = deviation(1);
  fit.rms_N = std::sqrt(out.squares / static_cast<double>(n)) * p.rise_N;
  const PartMeans parts = part_means(p.x, left, u[0], p.x.maxCoeff());
  const double noise = noise_variance(left);
  fit.misfit_N = misfit_of(parts, noise) * p.rise_N;
  fit.has_pattern = has_pattern(p, parts, left, noise, u[0], fit.force_N / p.rise_N);
  if (fit.misfit_N > kMisfit * fit.force_N)
    add_sentence(fit.remark, "the model does not describe the curve: it is off by " +
                                 percent(fit.misfit_N / fit.force_N) + " of the force");
  else if (fit.has_pattern)
    add_sentence(
        fit.remark,
        fmt::format("what the model leaves goes with depth: {} of the force, of one sign in "
                    "{} runs over {} parts",
                    percent(parts.rms() * p.rise_N / fit.force_N), parts.runs(), kParts));
  const double most_m = model.valid_to_m(press);
  fit.is_beyond = fit.depth_m > most_m;
  if (fit.is_beyond)
    add_sentence(fit.remark, fmt::format("deeper than the model holds to 1 % ({:.3g} of {:.3g} um)",
                                         1e6 * most_m, 1e6 * fit.depth_m));
  if (fit.contact_m < p.first_m) add_sentence(fit.remark, "its contact lies before the first row");
  return out;
}

// Deviations with the choice whether the free part slopes, each counted with its bic.
void hold_slope(const SolvedModel& tilted, double rows, SolvedModel& flat) {
  const double readings = std::max(8., rows / tilted.correlation_time);
  const double better =  // bic
      readings * std::log(flat.squares / std::max(tilted.squares, 1e-300)) - std::log(readings);
  const double share = 1 / (1 + std::exp(-better / 2));
  const auto held = [&](double value, double deviation, double other, double of_other) {
    return std::max(deviation, std::sqrt((1 - share) * square(deviation) +
                                         share * (square(of_other) + square(other - value))));
  };
  ModelFit& fit = flat.fit;
  const ModelFit& other = tilted.fit;
  fit.young_deviation_Pa =
      held(fit.young_Pa, fit.young_deviation_Pa, other.young_Pa, other.young_deviation_Pa);
  fit.contact_deviation_m =
      held(fit.contact_m, fit.contact_deviation_m, other.contact_m, other.contact_deviation_m);
}

}  // namespace

std::vector<ModelFit> fit_models(const Eigen::VectorXd& travel_m, const Eigen::VectorXd& push_N,
                                 const Indentation& press, const std::vector<std::string>& names,
                                 const ModelFitOptions& options) {
  ModelProblem p;
  Eigen::Index rows = travel_m.size();
  const double first_N = push_N.head(std::max<Eigen::Index>(1, rows / 10)).mean();
  if (options.force_share > 0 && options.force_share < 1) {
    const double limit_N = first_N + options.force_share * (push_N.maxCoeff() - first_N);
    rows = 0;
    while (rows < travel_m.size() && (push_N[rows] <= limit_N || rows < 8)) ++rows;
  }
  p.first_m = travel_m.head(rows).minCoeff();
  p.range_m = travel_m.head(rows).maxCoeff() - p.first_m;
  p.base_N = first_N;
  p.rise_N = push_N.head(rows).maxCoeff() - first_N;
  if (!(p.range_m > 0) || !(p.rise_N > 0)) return {};
  p.x = (travel_m.head(rows).array() - p.first_m) / p.range_m;
  p.y = (push_N.head(rows).array() - p.base_N) / p.rise_N;
  if (options.contact_m) p.contact = (*options.contact_m - p.first_m) / p.range_m;

  std::vector<SolvedModel> solved;
  for (const IndentationModel& model : indentation_models()) {
    if (!names.empty() && std::ranges::find(names, model.name) == names.end()) continue;
    if (!model.is_admissible(press)) continue;
    p.law = model.law ? model.law(press) : ModelLaw{};
    p.area_scale = 1;
    if (p.law)  // past the range of a table half of it serves
      for (double share = 1; share > 1e-6; share /= 2)
        if (const double area = p.law(share * p.range_m).area_m2; std::isfinite(area)) {
          p.area_scale = area;
          break;
        }
    p.has_slope = options.has_slope;
    auto found = solve(p, model, press);
    if (!found) continue;
    p.has_slope = true;
    if (!options.has_slope && model.law)
      if (const auto tilted = solve(p, model, press))
        hold_slope(*tilted, static_cast<double>(rows), *found);
    solved.push_back(std::move(*found));
  }
  if (solved.empty()) return {};
  const auto best = std::ranges::min_element(solved, {}, &SolvedModel::squares);
  const double readings = std::max(8., static_cast<double>(rows) / best->correlation_time);
  double least = kInfinity;
  for (SolvedModel& s : solved) {
    s.fit.bic = readings * std::log(std::max(s.squares, 1e-300)) +
                static_cast<double>(s.unknowns) * std::log(readings);
    least = std::min(least, s.fit.bic);
  }
  std::vector<ModelFit> fits;
  for (SolvedModel& s : solved) {
    s.fit.bic -= least;
    fits.push_back(std::move(s.fit));
  }
  return fits;
}

std::vector<std::vector<ModelFit>> fit_all(const std::vector<ModelFitTask>& tasks,
                                           const std::vector<std::string>& names, int jobs) {
  constexpr Eigen::Index kLeastReadings = 8;
  std::vector<std::vector<ModelFit>> fits(tasks.size());
  tbb::task_arena arena(jobs > 0 ? jobs : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
      const ModelFitTask& task = tasks[i];
      if (task.travel_m->size() >= kLeastReadings)
        fits[i] = fit_models(*task.travel_m, *task.push_N, task.press, names, task.options);
    });
  });
  return fits;
}

Eigen::VectorXd model_push_N(const ModelFit& fit, const Indentation& press,
                             const Eigen::VectorXd& travel_m) {
  const ModelLaw law = fit.model->law ? fit.model->law(press) : ModelLaw{};
  const double modulus_Pa = fit.young_Pa / (1 - square(press.poisson));
  return travel_m.unaryExpr([&](double travel) {
    const double depth_m = travel - fit.contact_m,
                 free_N = fit.baseline_N + fit.slope_N_m * depth_m;
    if (!(depth_m > 0)) return free_N;
    return free_N + (law ? modulus_Pa * law(depth_m).area_m2
                         : fit.force_N * std::pow(depth_m / fit.depth_m, fit.exponent));
  });
}

std::optional<std::size_t> best_model(const std::vector<ModelFit>& fits) {
  const bool any_holds = std::ranges::any_of(
      fits, [](const ModelFit& fit) { return fit.model->law && !fit.is_beyond; });
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits[i].model->law && !(any_holds && fits[i].is_beyond) &&
        (!best || fits[i].bic < fits[*best].bic - kSame))
      best = i;
  return best;
}

double chosen_deviation_Pa(const std::vector<ModelFit>& fits, std::size_t best) {
  double weights = 0, squares = 0;
  for (const ModelFit& fit : fits) {
    if (!fit.model->law || fit.is_beyond) continue;
    const double weight = std::exp((fits[best].bic - fit.bic) / 2);
    weights += weight;
    squares +=
        weight * (square(fit.young_deviation_Pa) + square(fit.young_Pa - fits[best].young_Pa));
  }
  return weights > 0 ? std::max(fits[best].young_deviation_Pa, std::sqrt(squares / weights))
                     : fits[best].young_deviation_Pa;
}

}  // namespace palpate::recordings
