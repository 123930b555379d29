#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kRings = 40;
constexpr int kStretches = 10;            // of a recording
constexpr double kDeviations = 3;         // of the contact, within which the curve may begin
constexpr Eigen::Index kMinFreeRows = 3;  // on either side, that show a sensor's drift

// Ring depths, denser where contact begins.
Eigen::VectorXd ring_depths(double first_m, double last_m) {
  return Eigen::VectorXd::NullaryExpr(kRings, [&](Eigen::Index i) {
    const double share = static_cast<double>(i) / kRings;
    return first_m + (last_m - first_m) * share * share;
  });
}

// Stiffness of the rings of a curve, which is taken as straight between them.
Eigen::VectorXd rings_of(const Eigen::VectorXd& ring_m, double last_m, auto&& curve) {
  Eigen::VectorXd c(ring_m.size());
  double before = 0;
  for (Eigen::Index i = 0; i < ring_m.size(); ++i) {
    const double to_m = i + 1 < ring_m.size() ? ring_m[i + 1] : last_m;
    const double slope = (curve(to_m) - curve(ring_m[i])) / (to_m - ring_m[i]);
    c[i] = slope - before;
    before = slope;
  }
  return c;
}

Eigen::MatrixXd curve_basis(SlowCurve kind, const Eigen::VectorXd& ring_m, double last_m,
                            double contact_deviation_m) {
  std::vector<Eigen::VectorXd> columns;
  if (kind == SlowCurve::free) {
    for (Eigen::Index i = 0; i < ring_m.size(); i += 2)
      columns.emplace_back(Eigen::VectorXd::Unit(ring_m.size(), i) / last_m);
  } else {
    std::vector<double> begins{0};
    if (contact_deviation_m > 0)
      for (const double share : {-1., -0.5, 0.5, 1.})
        begins.push_back(share * kDeviations * contact_deviation_m);
    for (const double begin_m : begins)
      for (const double power : {1., 1.5, 2., 3.})
        if (begin_m >= ring_m[0] - 1e-12 * last_m && begin_m < last_m / 2)
          columns.push_back(rings_of(ring_m, last_m, [&](double depth_m) {
            return std::pow(std::max(0., (depth_m - begin_m) / last_m), power);
          }));
  }
  Eigen::MatrixXd out(ring_m.size(), columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) out.col(j) = columns[j];
  return out;
}

struct DriftPrior {
  double over_N = 0, deviation_N = 0;
};

// Over a recording, from the free rows before contact and from what sensors usually do.
DriftPrior expected_drift(const TimedPress& p, double margin_m, double most_N) {
  DriftPrior usual{0, 0.1 * most_N};
  std::vector<double> time, force;
  double readings = 0;
  for (Eigen::Index i = 0; i < p.rows() && p.depth_m[i] < -margin_m; ++i)
    if (p.readings[i] > 0)
      time.push_back(p.time_s[i]), force.push_back(p.push_N[i]), readings += p.readings[i];
  const Eigen::Index n = time.size();
  if (n < kMinFreeRows) return usual;
  const Eigen::Map<const Eigen::VectorXd> t(time.data(), n), f(force.data(), n);
  const double whole_s = p.time_s[p.rows() - 1] - p.time_s[0],
               spread_s = (t.array() - t.mean()).matrix().norm(),
               row_N = p.noise_N / std::sqrt(readings / static_cast<double>(n));
  if (!(spread_s > 0)) return usual;
  const Line line = fit_line(t, f);
  const double measured_N = line.slope * whole_s,
               error_N = std::max(line.deviation, row_N) / spread_s * whole_s;
  // Two readings of one number.
  const double precision = 1 / (error_N * error_N),
               before = 1 / (usual.deviation_N * usual.deviation_N);
  return {measured_N * precision / (precision + before), 1 / std::sqrt(precision + before)};
}

}  // namespace

PressGroup::PressGroup(const std::vector<TimedPress>& presses, SlowCurve curve) {
  double deepest_m = 0, deviation_m = 0, free_m = 0;
  for (const TimedPress& p : presses) rows_ += p.rows();
  push_N_.resize(rows_), noise_N_ = weight_ = Eigen::VectorXd::Zero(rows_);
  stretch_.assign(rows_, -1);
  Eigen::Index first = 0;
  for (const TimedPress& p : presses) {
    PressInGroup part{p, first};
    if (!presses_.empty() && p.contact_deviation_m > 0) {
      part.shift = static_cast<int>(shifted_.size());
      shifted_.push_back(presses_.size());
    }
    deepest_m = std::max(deepest_m, p.depth_m.maxCoeff());
    free_m = std::max(free_m, -p.depth_m.minCoeff());
    deviation_m = std::max(deviation_m, p.contact_deviation_m);
    const double most_N = p.push_N.maxCoeff();
    const double margin_m = kDeviations * p.contact_deviation_m;
    // Without a free part the level is that of first touch, where the body carries no force.
    const double level_N = p.depth_m[0] < -margin_m ? 0 : p.push_N[0];
    Eigen::Index before = 0, after = 0, touching = 0;
    bool was_in = false;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      push_N_[first + i] = p.push_N[i];
      was_in |= p.depth_m[i] > 0;
      if (!(p.readings[i] > 0) ||
          (was_in && p.push_N[i] < level_N - std::max(3 * p.noise_N, 0.01 * most_N)))
        continue;  // the tip is pulled
      noise_N_[first + i] = p.noise_N / std::sqrt(p.readings[i]);
      weight_[first + i] =
          1 / std::hypot(noise_N_[first + i], 0.002 * most_N);  // no bed describes more
      if (p.depth_m[i] < -margin_m) (was_in ? after : before) += 1;
      touching += p.depth_m[i] > 0;
    }
    if (before < kMinFreeRows || after < kMinFreeRows) {
      const DriftPrior drift = expected_drift(p, margin_m, most_N);
      part.drift_N = drift.over_N, part.drift_deviation_N = drift.deviation_N;
      drifts_ += 1;
    }
    Eigen::Index seen = 0;
    for (Eigen::Index i = 0; i < p.rows(); ++i)
      if (p.depth_m[i] > 0 && weight_[first + i] > 0)
        stretch_[first + i] = stretches_ + static_cast<int>(kStretches * seen++ / touching);
    stretches_ += kStretches;
    presses_.push_back(std::move(part));
    first += p.rows();
  }
  const double begin_m = -std::min(kDeviations * deviation_m, free_m);
  ring_m_ = ring_depths(begin_m, deepest_m);
  curve_ = curve_basis(curve, ring_m_, deepest_m, deviation_m);
}

PressGroup::FittedRows PressGroup::counted(std::size_t recording) const {
  const PressInGroup& part = presses_[recording];
  FittedRows out;
  for (Eigen::Index i = part.first; i < part.first + part.time_s.size(); ++i)
    if (weight_[i] > 0) out.row.push_back(i);
  out.weight = weight_(out.row);
  out.noise = out.weight.cwiseProduct(noise_N_(out.row));
  out.time_s.resize(out.weight.size());
  for (std::size_t k = 0; k < out.row.size(); ++k)
    out.time_s[k] = part.time_s[out.row[k] - part.first];
  return out;
}

void PressGroup::put_parts(std::size_t recording, const Relaxation& relaxation,
                           const double* shifts, Eigen::MatrixXd& parts) const {
  const PressInGroup& part = presses_[recording];
  const double shift_m = part.shift < 0 ? 0 : shifts[part.shift] * part.contact_deviation_m;
  parts.middleRows(part.first, part.time_s.size()) =
      ring_forces(part.time_s, part.depth_m.array() - shift_m, relaxation, ring_m_) * curve_;
}

Eigen::MatrixXd PressGroup::parts(const Relaxation& relaxation, const double* shifts) const {
  Eigen::MatrixXd out(rows_, curve_.cols());
  for (std::size_t r = 0; r < presses_.size(); ++r) put_parts(r, relaxation, shifts, out);
  return out;
}

PressGroup::Solution PressGroup::solve(const Eigen::MatrixXd& column, const double* shifts,
                                       const std::vector<char>& held_out) const {
  Eigen::MatrixXd sensor = Eigen::MatrixXd::Zero(rows_, 2 * presses_.size());
  const Eigen::Index sensors = sensor.cols();
  Eigen::VectorXd precision = Eigen::VectorXd::Zero(sensors), expected = precision;
  for (std::size_t r = 0; r < presses_.size(); ++r) {
    const PressInGroup& part = presses_[r];
    const Eigen::Index level_at = 2 * r;
    const Eigen::Index n = part.time_s.size();
    sensor.col(level_at).segment(part.first, n).setOnes();
    sensor.col(level_at + 1).segment(part.first, n) =
        part.time_s / (part.time_s[n - 1] - part.time_s[0]);
    if (!(part.drift_deviation_N > 0)) continue;
    precision[level_at + 1] = 1 / (part.drift_deviation_N * part.drift_deviation_N);
    expected[level_at + 1] = part.drift_N;
  }
  Eigen::VectorXd weight = weight_;
  for (Eigen::Index i = 0; i < rows_; ++i)
    if (held_out[i]) weight[i] = 0;

  Eigen::MatrixXd weighted = weight.asDiagonal() * column;
  Eigen::VectorXd right = weight.cwiseProduct(push_N_);
  const Eigen::MatrixXd free = weight.asDiagonal() * sensor;
  Eigen::MatrixXd inner = free.transpose() * free;
  inner.diagonal() += precision;
  const auto solver = inner.ldlt();
  Eigen::MatrixXd gram = weighted.transpose() * weighted;
  Eigen::VectorXd to = weighted.transpose() * right;
  const Eigen::MatrixXd cross = free.transpose() * weighted;
  const Eigen::VectorXd known = precision.cwiseProduct(expected),
                        level = free.transpose() * right + known;
  gram -= cross.transpose() * solver.solve(cross);
  to -= cross.transpose() * solver.solve(level);
  // Columns may be alike but for rounding.
  const Eigen::VectorXd scale = gram.diagonal().unaryExpr(
      [](double square) { return square > 0 ? 1 / std::sqrt(square) : 0; });
  gram = scale.asDiagonal() * gram * scale.asDiagonal();
  gram.diagonal().array() += 1e-12;
  const Eigen::LLT<Eigen::MatrixXd> root(gram);
  const Eigen::VectorXd found = scale.cwiseProduct(
      nonnegative_least_squares(root.matrixU(), root.matrixL().solve(scale.cwiseProduct(to))));
  Solution out;
  out.curve = found;
  out.fitted_N = column * found;
  const Eigen::VectorXd of_sensor =
      solver.solve(free.transpose() * (right - weight.cwiseProduct(out.fitted_N)) + known);
  out.fitted_N += sensor * of_sensor;
  out.slopes.resize(rows_, sensors + (found.array() > 0).count());
  out.slopes.rightCols(sensors) = free;
  for (Eigen::Index j = 0, at = 0; j < found.size(); ++j)
    if (found[j] > 0) out.slopes.col(at++) = weighted.col(j);
  out.residual.resize(residuals());
  out.residual.head(rows_) = weight_.cwiseProduct(push_N_ - out.fitted_N);
  for (Eigen::Index s = 0; s < this->shifts(); ++s) out.residual[rows_ + s] = shifts[s];
  for (Eigen::Index k = 0, at = rows_ + this->shifts(); k < sensors; ++k)
    if (precision[k] > 0)
      out.residual[at++] = std::sqrt(precision[k]) * (of_sensor[k] - expected[k]);
  return out;
}

}  // namespace palpate::recordings
