#include "libfem/calibrate/material_search.hpp"

#include <algorithm>
#include <utility>

namespace palpate::fem {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double kReach = 12;  // how far bounds are looked for, in units of the search

}  // namespace

MaterialSearch::MaterialSearch(MaterialParameters start, const Observations& observed,
                               const MaterialResponses& responses, const IdentifyOptions& options)
    : law_(find_law(start.law, "law")),
      start_(std::move(start)),
      value_(observed.value),
      responses_(responses),
      options_(options) {
  const double largest = value_.lpNorm<Eigen::Infinity>();
  std::vector<double> stated;
  for (const double s : observed.deviation)
    if (s > 0 && std::isfinite(s)) stated.push_back(s);
  std::nth_element(stated.begin(), stated.begin() + stated.size() / 2, stated.end());
  is_stated = !stated.empty();
  // A deviation that no row states is 1 % of the largest value.
  const double usual = is_stated ? stated[stated.size() / 2] : 0.01 * largest;
  deviation = observed.deviation.unaryExpr([&](double s) {
    // A solver leaves a thousandth of the largest value.
    return std::hypot(s > 0 && std::isfinite(s) ? s : usual, is_stated ? 1e-3 * largest : 0);
  });
  if (observed.shared.size() > 0)
    visit_groups(observed.group, [&](Index first, Index rows) {
      VectorXd weight =
          observed.shared.segment(first, rows).cwiseQuotient(deviation.segment(first, rows));
      if (weight.norm() > 0) shared_.push_back({first, rows, std::move(weight)});
    });
  moduli_ = moduli_of(start_);
  const auto is_free = [&](std::size_t i) {
    return std::find(options_.free.begin(), options_.free.end(), i) != options_.free.end();
  };
  scales = options_.may_scale && !moduli_.empty() &&
           std::all_of(moduli_.begin(), moduli_.end(),
                       [&](std::size_t m) { return is_free(m) || start_.values[m] == 0; });
  unit_sum_ = sum_of_moduli(start_);
  make_coordinates();
  set_num_residuals(static_cast<int>(value_.size()));
  mutable_parameter_block_sizes()->push_back(size());
}

// The inverse root of 1 + w wT is 1 - (1 - 1 / sqrt(1 + |w|^2)) w wT / |w|^2.
MatrixXd MaterialSearch::whitened(const MatrixXd& rows) const {
  MatrixXd out = deviation.cwiseInverse().asDiagonal() * rows;
  for (const SharedError& of : shared_) {
    const double squares = of.weight.squaredNorm();
    auto part = out.middleRows(of.first, of.rows);
    part -= ((1 - 1 / std::sqrt(1 + squares)) / squares * of.weight) *
            (of.weight.transpose() * part).eval();
  }
  return out;
}

std::vector<double> MaterialSearch::shared_error(const VectorXd& residual) const {
  std::vector<double> out;
  for (const SharedError& of : shared_)
    out.push_back(of.weight.dot(residual.segment(of.first, of.rows)
                                    .cwiseQuotient(deviation.segment(of.first, of.rows))) /
                  (1 + of.weight.squaredNorm()));
  return out;
}

MaterialParameters MaterialSearch::at(const double* y) const {
  MaterialParameters material = start_;
  for (std::size_t k = 0; k < coordinates.size(); ++k)
    material.values[coordinates[k].index] = coordinates[k].from(y[k]);
  return material;
}

VectorXd MaterialSearch::place(const MaterialParameters& material) const {
  VectorXd y(size());
  for (int k = 0; k < size(); ++k) {
    const Coordinate& c = coordinates[k];
    y[k] = std::clamp(c.to(material.values[c.index]), c.low, c.high);
  }
  return y;
}

bool MaterialSearch::is_refused(const MaterialParameters& material) const {
  for (const Coordinate& c : coordinates)  // exp overflows for a modulus far above the largest
    if (!std::isfinite(material.values[c.index])) return true;
  return law_.refusal(material.values).is_refused();
}

std::optional<MatrixXd> MaterialSearch::sensitivities(const VectorXd& y,
                                                      const VectorXd& response) const {
  const Index k = size();
  const MaterialParameters here = at(y.data());
  const Index by_scaling = scales ? largest_free_modulus(here) : -1;
  std::vector<MaterialParameters> materials;
  std::vector<std::pair<Index, double>> step;
  for (Index j = 0; j < k; ++j) {
    if (j == by_scaling) continue;
    // Relative, above the scatter of a solver.
    const double size = 0.05 * (coordinates[j].is_log ? 1 : std::max(std::abs(y[j]), 0.2));
    for (const double side : {1.0, -1.0}) {
      VectorXd moved = y;
      moved[j] += side * size;
      const MaterialParameters material = at(moved.data());
      if (is_refused(material)) continue;
      materials.push_back(material);
      step.emplace_back(j, side * size);
    }
  }
  const std::vector<VectorXd> moved = responses_(materials);
  MatrixXd J = MatrixXd::Zero(value_.size(), k);
  for (Index j = 0; j < k; ++j) {
    std::vector<std::size_t> sides;
    for (std::size_t i = 0; i < step.size(); ++i)
      if (step[i].first == j && moved[i].size() > 0) sides.push_back(i);
    if (j == by_scaling) continue;
    if (sides.empty()) return std::nullopt;
    if (sides.size() == 2)
      J.col(j) = (moved[sides[0]] - moved[sides[1]]) / (2 * step[sides[0]].second);
    else
      J.col(j) = (moved[sides[0]] - response) / step[sides[0]].second;
  }
  if (by_scaling < 0) return J;
  // (M43a): the sum of modulus times derivative is the response.
  VectorXd rest = response;
  for (Index j = 0; j < k; ++j) {
    const Coordinate& c = coordinates[j];
    if (j != by_scaling && is_modulus(c.index))
      rest -= J.col(j) * (here.values[c.index] / c.slope(y[j]));
  }
  const Coordinate& c = coordinates[by_scaling];
  J.col(by_scaling) = rest * (c.slope(y[by_scaling]) / here.values[c.index]);
  return J;
}

bool MaterialSearch::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  const Index k = size();
  const VectorXd y = Eigen::Map<const VectorXd>(parameters[0], k);
  const MaterialParameters material = at(y.data());
  if (options_.progress.stopped() || is_refused(material)) return false;
  const VectorXd response = responses_({material}).front();
  if (response.size() == 0 || !response.allFinite()) return false;
  Eigen::Map<VectorXd>(residuals, value_.size()) = whitened(response - value_);
  if (!jacobians || !jacobians[0]) return true;
  const std::optional<MatrixXd> J = sensitivities(y, response);
  if (!J) return false;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      jacobians[0], value_.size(), k) = whitened(*J);
  return true;
}

MaterialParameters MaterialSearch::scaled_to_fit(MaterialParameters material,
                                                 const VectorXd& response) const {
  const VectorXd model = whitened(response);
  const double factor = model.dot(whitened(value_).col(0)) / model.squaredNorm();
  if (scales && factor > 0)
    for (const std::size_t m : moduli_) material.values[m] *= factor;
  return material;
}

double MaterialSearch::size_of(const MaterialParameters& material, std::size_t k) const {
  const std::size_t index = coordinates[k].index;
  // A modulus below a hundredth of all moduli is scaled by that.
  return std::max(std::abs(material.values[index]),
                  is_modulus(index) ? 0.01 * sum_of_moduli(material) : 1e-9);
}

bool MaterialSearch::is_modulus(std::size_t index) const {
  return std::find(moduli_.begin(), moduli_.end(), index) != moduli_.end();
}

Index MaterialSearch::largest_free_modulus(const MaterialParameters& material) const {
  Index best = -1;
  const auto modulus = [&](Index k) { return std::abs(material.values[coordinates[k].index]); };
  for (Index k = 0; k < size(); ++k)
    if (is_modulus(coordinates[k].index) && (best < 0 || modulus(k) > modulus(best))) best = k;
  return best;
}

void MaterialSearch::make_coordinates() {
  for (const std::size_t index : options_.free)  // off the border, where there is one side alone
    if (start_.values[index] == 0) start_.values[index] = is_modulus(index) ? 0.1 * unit_sum_ : 0.1;
  for (const std::size_t index : options_.free) {
    const double value = start_.values[index];
    const auto refuses = [&](double other, double scale) {
      MaterialParameters material = start_;
      for (const std::size_t i : options_.free)
        if (i != index && is_modulus(i)) material.values[i] *= scale;
      material.values[index] = other;
      return is_refused(material);
    };
    Coordinate c{.index = index};
    c.is_log = refuses(0, 1) && refuses(-value, 1);
    c.unit = c.is_log ? std::copysign(1, value) : is_modulus(index) ? unit_sum_ : 1;
    // A bound that moves with the other parameters is none of this one's.
    const auto bound = [&](double side, double scale) {
      double inside = c.to(value), outside = inside + side * kReach;
      if (!refuses(c.from(outside), scale)) return outside;
      for (int i = 0; i < 100; ++i) {
        const double middle = (inside + outside) / 2;
        (refuses(c.from(middle), scale) ? outside : inside) = middle;
      }
      return std::abs(inside) < 1e-12 && !refuses(0, scale) ? 0 : inside;
    };
    for (const double side : {-1.0, 1.0}) {
      const double found = bound(side, 1);
      if (std::abs(found - c.to(value)) > kReach * 0.999 || refuses(value, 100) ||
          std::abs(bound(side, 100) - found) > 1e-9)
        continue;
      (side < 0 ? c.low : c.high) = found;
    }
    coordinates.push_back(c);
  }
}

}  // namespace palpate::fem
