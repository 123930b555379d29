#include "libfit/scan/gauss_newton.hpp"

#include <fmt/core.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <memory>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::scan {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

// Robust deviations from which on a residual counts less (Huber). Passes left out of 5,500 rows of
// a robot (palpation_1) have a loss 4.5 % lower with half of it and 0.3 % higher with twice.
constexpr double kKnee = 3;
constexpr int kPieces = 5;  // of the normal curves: with 8 passes left out are 0.3 points better in
                            // the median and 1.5 worse at p95 (a sketch on palpation_1)

// Nodes on the sphere whose normals are most like the forces' directions, by least squares.
Nodes nodes_for(const Passes& passes, double spacing_m) {
  const Eigen::VectorXd force_N = passes.force_N.rowwise().norm();
  const double least_N = relative_floor(force_N.maxCoeff());
  const Eigen::RowVector3d middle = passes.position_m.colwise().mean();
  Vec3 sum = Vec3::Zero();
  double count = 0, product = 0, square = 0;
  for (Eigen::Index row = 0; row < passes.rows(); ++row) {
    if (!(force_N[row] > least_N)) continue;
    const Eigen::RowVector3d away = passes.position_m.row(row) - middle;
    sum += passes.force_N.row(row).transpose() / force_N[row], ++count;
    product -= away.dot(passes.force_N.row(row)) / force_N[row];
    square += away.squaredNorm();
  }
  // Six scans of organs have 0.65 to 0.90, forces from a robot's motor currents in the air 0.11.
  if (!(sum.norm() > 0.3 * count))
    throw Error("scan",
                fmt::format("the forces have no common direction ({:.2f} of their sizes adds up)",
                            count > 0 ? sum.norm() / count : 0),
                "Check the columns of the force, its frame and its zero.");
  return {passes.position_m, sum / count, spacing_m, product / square};
}

// Spacing at which a square that the scan covers has this many rows.
double spacing_for(const Passes& passes, double rows_per_square) {
  double spacing_m = 0.05 * extent_m(passes.position_m).norm();
  for (int round = 0; round < 3; ++round) {
    const Nodes nodes = nodes_for(passes, spacing_m);
    std::vector<char> is_covered(nodes.cells(), 0);
    for (Eigen::Index row = 0; row < passes.rows(); ++row) {
      const Vec3 x = nodes.coordinates(passes.position_m.row(row));
      if (const int cell = nodes.at(x[0], x[1]).cell; cell >= 0) is_covered[cell] = 1;
    }
    const auto squares = std::ranges::count(is_covered, 1);
    spacing_m *= std::sqrt(rows_per_square * double(squares) / double(passes.rows()));
  }
  return spacing_m;
}

void add_square(std::vector<Eigen::Triplet<double>>& entries, double weight,
                std::initializer_list<std::pair<int, double>> terms) {
  for (const auto& [i, a] : terms)
    for (const auto& [j, b] : terms) entries.emplace_back(i, j, weight * a * b);
}

// Prior of smoothness between nodes, and weak ones that decide what no row says. The loss of passes
// left out of the same rows is 9 % higher with a tenth of the weight of curves and 5 % lower with
// ten times; of heights 0 and 4 % higher, of friction 3 and 3 %; without the slope's, 23 %.
Sparse prior_of(const Nodes& nodes, const Unknowns& u, double strength) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto bend = [&](double weight, int a, int b, int c) {
    add_square(entries, weight * strength, {{a, 1.0}, {b, -2.0}, {c, 1.0}});
  };
  for (const auto& [a, b, c] : nodes.triples()) {
    for (int j = 0; j < u.increments; ++j)
      bend(0.07, u.increment(a, j), u.increment(b, j), u.increment(c, j));
    bend(0.3, u.height(a), u.height(b), u.height(c));
  }
  const auto differ = [&](double weight, int a, int b) {
    add_square(entries, weight * strength, {{a, 1.0}, {b, -1.0}});
  };
  for (const auto& [a, b] : nodes.pairs()) {
    differ(0.3, u.friction(a), u.friction(b));
    differ(0.1, u.friction_slope(a), u.friction_slope(b));
    for (int j = 0; j < u.increments; ++j) differ(0.001, u.increment(a, j), u.increment(b, j));
    differ(1e-5, u.height(a), u.height(b));
  }
  for (const int k : {kLambda, kTime})
    entries.emplace_back(u.shared(k), u.shared(k), 0.3 * strength);
  for (int n = 0; n < u.nodes; ++n) {
    for (int j = 0; j + 1 < u.increments; ++j)
      differ(0.03, u.increment(n, j), u.increment(n, j + 1));
    entries.emplace_back(u.friction_slope(n), u.friction_slope(n), 0.01 * strength);
  }
  Sparse out(u.size(), u.size());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

// Smooth heights through places in coordinates of the nodes; those outside say nothing. bending:
// the weight of differences between nodes.
Eigen::VectorXd heights_through(const Nodes& nodes, const Points& places, double bending) {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(nodes.count());
  for (const auto& x : places.rowwise()) {
    const Nodes::CellPlace at = nodes.at(x[0], x[1]);
    if (at.cell < 0) continue;
    const auto& node = nodes.cell(at.cell).height;
    for (int i = 0; i < Nodes::kHeights; ++i) {
      right[node[i]] += at.height[i] * x[2];
      for (int j = 0; j < Nodes::kHeights; ++j)
        entries.emplace_back(node[i], node[j], at.height[i] * at.height[j]);
    }
  }
  for (const auto& [a, b, c] : nodes.triples())
    add_square(entries, bending, {{a, 1.0}, {b, -2.0}, {c, 1.0}});
  for (const auto& [a, b] : nodes.pairs()) add_square(entries, 1e-6, {{a, 1.0}, {b, -1.0}});
  Sparse matrix(nodes.count(), nodes.count());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Sparse>(matrix).solve(right);
}

double scale_of(const Eigen::VectorXd& error, const Mask& mask) {
  std::vector<double> sizes;
  for (Eigen::Index row = 0; row < error.size(); ++row)
    if (mask[row]) sizes.push_back(error[row]);
  return 1.4826 * upper_median(sizes);
}

}  // namespace

ScanIdentification::ScanIdentification(const Samples& scans, int jobs, const Progress& progress,
                                       const Surface* body)
    : passes(scans),
      nodes(nodes_for(passes, spacing_for(passes, 200))),  // half: 19 % more loss, twice: 5 %
      jobs_(jobs),
      progress_(progress) {
  force_N_ = passes.force_N.rowwise().norm();
  floor_N_ = relative_floor(force_N_.maxCoeff());
  unknowns.nodes = nodes.count();
  unknowns.spacing_m = nodes.spacing_m();
  start(body);
}

// Heights from the outermost rows of each cell, smooth, or of the body; curves of one stiffness.
void ScanIdentification::start(const Surface* body) {
  // A pass may come down to the body and leave it: how high is no matter.
  Mask is_near(passes.rows(), 0);
  for (std::size_t pass = 0; pass < passes.count(); ++pass) {
    Eigen::Index begin = passes.first[pass], end = passes.first[pass + 1];
    while (begin < end && !(force_N_[begin] > floor_N_)) ++begin;
    while (begin < end && !(force_N_[end - 1] > floor_N_)) --end;
    std::fill(is_near.begin() + begin, is_near.begin() + end, 1);
  }
  std::vector<std::vector<double>> level(nodes.cells());
  for (Eigen::Index row = 0; row < passes.rows(); ++row) {
    const Vec3 x = nodes.coordinates(passes.position_m.row(row));
    if (is_near[row]) level[nodes.at(x[0], x[1]).cell].push_back(x[2]);
  }
  Points outermost(std::ranges::count(is_near, 1), 3);
  for (Eigen::Index row = 0, at = 0; row < passes.rows(); ++row) {
    if (!is_near[row]) continue;
    const Vec3 x = nodes.coordinates(passes.position_m.row(row));
    std::vector<double>& levels = level[nodes.at(x[0], x[1]).cell];
    const auto outer = levels.begin() + std::ssize(levels) / 32;
    std::nth_element(levels.begin(), outer, levels.end());
    outermost.row(at++) << x[0], x[1], *outer;
  }
  parameters.height_m = heights_through(nodes, outermost, 1);
  if (body != nullptr) {
    const BoxTree boxes = triangle_boxes(*body);
    Points places = nodes.mesh(parameters.height_m, kParts).surface.vertices;
    for (auto place : places.rowwise())
      place = nodes.coordinates(closest_point(*body, boxes, place)->position).transpose();
    // A hundredth: rows scatter, and the mesh does not.
    parameters.height_m = heights_through(nodes, places, 0.01);
  }
  std::vector<double> depths_m, stiffness_N_m;
  double pressed_m = 0;  // beside the scan
  for (Eigen::Index row = 0; row < passes.rows(); ++row) {
    const double depth_m = nodes.foot(passes.position_m.row(row), parameters.height_m).depth_m;
    if (!passes.is_scan[row])
      pressed_m = std::max(pressed_m, depth_m);
    else if (is_near[row])
      depths_m.push_back(depth_m);
    if (force_N_[row] > floor_N_ && depth_m > 0) stiffness_N_m.push_back(force_N_[row] / depth_m);
  }
  const double scanned_m = 1.25 * stated_quantile(depths_m, 0.99);
  unknowns.depth_m = std::max(scanned_m, 1.25 * pressed_m);
  unknowns.force_N = upper_median(std::vector<double>(force_N_.begin(), force_N_.end()));
  if (!(unknowns.depth_m > 0) || stiffness_N_m.empty())
    throw Error("scan", "no row is deeper than another", "Record presses to several depths.");
  basis.degree = 3;
  for (int i = 0; i <= kPieces; ++i) basis.knots_m.push_back(scanned_m * i / kPieces);
  // Presses that go deeper have pieces as long, but at most twice as many in all.
  const double deeper_m = unknowns.depth_m - scanned_m;
  const int more = std::min(kPieces, static_cast<int>(std::ceil(deeper_m / basis.knots_m[1])));
  for (int i = 1; i <= more; ++i) basis.knots_m.push_back(scanned_m + deeper_m * i / more);
  unknowns.increments = kPieces + more + 2;
  parameters.increment_N = Eigen::MatrixXd::Constant(
      nodes.count(), unknowns.increments,
      upper_median(stiffness_N_m) * unknowns.depth_m / unknowns.increments);
  parameters.friction = Eigen::VectorXd::Constant(nodes.count(), 0.3);
  parameters.friction_slope_1_m = Eigen::VectorXd::Zero(nodes.count());
  is_free.assign(unknowns.size(), 1);
  std::fill(is_free.begin() + unknowns.shared(0), is_free.end(), 0);
  for (int n = 0; n < nodes.count(); ++n) is_free[unknowns.height(n)] = body == nullptr;
}

Eigen::VectorXd ScanIdentification::relative_errors(const Walked& walked) const {
  Eigen::VectorXd out(passes.rows());
  for (Eigen::Index row = 0; row < out.size(); ++row)
    out[row] = (passes.force_N.row(row) - walked.reading_N.row(row)).norm() /
               std::max(force_N_[row], floor_N_);
  return out;
}

// Mean of Huber's loss over the rows that are marked so.
double ScanIdentification::loss(const Eigen::VectorXd& error, double scale,
                                const Mask& mask) const {
  double sum = 0, count = 0;
  for (Eigen::Index row = 0; row < error.size(); ++row) {
    if (!mask[row]) continue;
    const double e = error[row] / scale;
    sum += e < kKnee ? 0.5 * e * e : kKnee * (e - 0.5 * kKnee);
    ++count;
  }
  return count > 0 ? sum * scale * scale / count : 0;
}

RelativeErrors ScanIdentification::errors(const Mask& mask) const {
  const Eigen::VectorXd all = relative_errors(walk(mask));
  std::vector<double> rows;
  for (Eigen::Index row = 0; row < all.size(); ++row)
    if (mask[row] && force_N_[row] > floor_N_) rows.push_back(all[row]);
  return {stated_quantile(rows, 0.5), stated_quantile(rows, 0.95), stated_quantile(rows, 1)};
}

double ScanIdentification::loss_of(const Mask& mask) const {
  return loss(relative_errors(walk(mask)), 0.1, mask);
}

// Changes of all readings by free numbers of the recording, by differences. Those that need a
// replay are taken over where they are there already: they cost a walk each, and hardly change.
void ScanIdentification::update_changes(const Eigen::VectorXd& x, const Walked& walked,
                                        const Mask& mask, std::map<int, Points>& changes) const {
  for (const SharedUnknown& of : kSharedUnknowns)
    for (int k = of.first; k < of.first + of.count && is_free[unknowns.shared(k)]; ++k) {
      if (of.needs_replay && changes.contains(k)) continue;
      Eigen::VectorXd moved = x;
      const double step = 0.05;  // of 10 ms, of a share, of a logarithm: well above ticks' rounding
      moved[unknowns.shared(k)] += step;
      const ScanParameters p = unknowns.parameters_of(moved);
      const Points reading_N =
          of.needs_replay
              ? PlayedBody(nodes, p, basis, kParts).walk(passes, mask, false, jobs_).reading_N
              : readings(walked.force_N, passes, p.recording);
      changes[k] = (reading_N - walked.reading_N) / step;
    }
}

// Solves for the step that keeps bounds: unknowns that would cross theirs stay there.
Eigen::VectorXd ScanIdentification::bounded_step(const ScanEquations& normal,
                                                 const Eigen::VectorXd& room) const {
  Mask free = this->is_free;
  for (Eigen::Index i = 0; i < room.size(); ++i)  // those at their bound that press against it
    if (!(room[i] < 0) && normal.right[i] < 0) free[i] = 0;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(room.size());
  for (int round = 0; round < 2; ++round) {
    std::vector<int> number(room.size(), -1);
    int count = 0;
    for (Eigen::Index i = 0; i < room.size(); ++i)
      if (free[i]) number[i] = count++, step[i] = 0;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right(count), full = normal.right - normal.matrix * step;
    for (Eigen::Index i = 0; i < room.size(); ++i)
      if (number[i] >= 0) right[number[i]] = full[i];
    for (int c = 0; c < normal.matrix.outerSize(); ++c)
      for (Sparse::InnerIterator it(normal.matrix, c); it; ++it)
        if (number[it.row()] >= 0 && number[c] >= 0)
          entries.emplace_back(number[it.row()], number[c], it.value());
    Sparse matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd found = Eigen::SimplicialLDLT<Sparse>(matrix).solve(right);
    bool is_within = true;
    for (Eigen::Index i = 0; i < room.size(); ++i) {
      if (number[i] < 0) continue;
      step[i] = found[number[i]];
      if (step[i] >= room[i]) continue;
      step[i] = room[i];
      free[i] = 0;
      is_within = false;
    }
    if (is_within) break;
  }
  return step;
}

// Gauss-Newton on the rows that are marked, damped where a step does not lower the loss.
void ScanIdentification::fit(const Mask& mask, int most_steps) {
  const double count = static_cast<double>(std::ranges::count(mask, 1));
  const Sparse prior = prior_of(nodes, unknowns, smoothness * 0.05 * count / nodes.cells());
  Eigen::VectorXd x = unknowns.vector_of(parameters);
  const Eigen::VectorXd lower = unknowns.lower();
  auto body = std::make_unique<PlayedBody>(nodes, parameters, basis, kParts);
  Walked walked = body->walk(passes, mask, true, jobs_);
  std::map<int, Points> changes;
  double damping = 1e-4;
  for (int step = 0; step < most_steps; ++step) {
    if (progress_.stopped()) return;
    const Eigen::VectorXd error = relative_errors(walked);
    const double scale = scale_of(error, mask);
    const auto cost = [&](const Eigen::VectorXd& e, const Eigen::VectorXd& at) {
      return count * loss(e, scale, mask) + 0.5 * at.dot(prior * at);
    };
    const double before = cost(error, x);
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(passes.rows());
    for (Eigen::Index row = 0; row < weight.size(); ++row)
      if (mask[row])
        weight[row] = std::sqrt(std::min(1.0, kKnee * scale / error[row])) /
                      std::max(force_N_[row], floor_N_);
    update_changes(x, walked, mask, changes);
    normal_ = linearise(nodes, unknowns, *body, walked, passes, parameters, weight, changes);
    normal_.matrix += prior;
    normal_.right -= prior * x;
    bool is_lower = false;
    double after = before;
    for (int attempt = 0; attempt < 5 && !is_lower; ++attempt) {
      ScanEquations damped = normal_;
      const Eigen::VectorXd diagonal = normal_.matrix.diagonal();
      Sparse added(x.size(), x.size());
      added.setIdentity();
      for (Eigen::Index i = 0; i < x.size(); ++i)
        added.coeffRef(i, i) = damping * diagonal[i] + 1e-9;
      damped.matrix += added;
      const Eigen::VectorXd tried = (x + bounded_step(damped, lower - x)).cwiseMax(lower);
      const ScanParameters p = unknowns.parameters_of(tried);
      auto other = std::make_unique<PlayedBody>(nodes, p, basis, kParts);
      Walked there = other->walk(passes, mask, true, jobs_);
      after = cost(relative_errors(there), tried);
      is_lower = after < before;
      damping = is_lower ? std::max(0.2 * damping, 1e-5) : 10 * damping;
      if (!is_lower) continue;
      x = tried, parameters = p, body = std::move(other), walked = std::move(there);
    }
    scale_ = scale;
    if (!is_lower || after > 0.998 * before) break;
  }
}

// Standard errors of the recording's numbers from the last normal equations. Neighbouring rows
// with correlation r count (1 - r) / (1 + r).
Eigen::VectorXd ScanIdentification::deviations(const Walked& walked) const {
  double squares = 0, products = 0;
  Vec3 before = Vec3::Zero();
  for (Eigen::Index row = 0; row < passes.rows(); ++row) {
    const Vec3 relative = (passes.force_N.row(row) - walked.reading_N.row(row)).transpose() /
                          std::max(force_N_[row], floor_N_);
    squares += relative.squaredNorm();
    products += relative.dot(before);
    before = relative;
  }
  const double r = std::clamp(products / squares, 0.0, 0.99),
               variance = scale_ * scale_ / 3 * (1 + r) / (1 - r);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(kShared);
  for (int k = 0; k < kShared; ++k) {
    if (!is_free[unknowns.shared(k)]) continue;
    ScanEquations unit{normal_.matrix, Eigen::VectorXd::Unit(unknowns.size(), unknowns.shared(k))};
    const Eigen::VectorXd free_room = Eigen::VectorXd::Constant(unknowns.size(), -kInfinity);
    out[k] = std::sqrt(std::max(0.0, variance * bounded_step(unit, free_room)[unknowns.shared(k)]));
  }
  return out;
}

}  // namespace palpate::scan
