#include "libfit/fit/neighbours/graph_quadratic.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {
namespace {

constexpr double kMinVariance = 1e-8;
constexpr double kKnee = 3;  // standard deviations beyond which neighbours differ for sure
constexpr std::size_t kFewestEdges = 8;  // to judge what neighbours have in common
constexpr double kMinShare = 1e-4;
constexpr int kMaxRounds = 30;    // of active sets: 2 to 5 are usual
constexpr int kMaxSweeps = 5000;  // of Gauss-Seidel

using Mask = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Standard normal deviate of a chi-square with n degrees of freedom.
double deviate(double chi_square, double n) {
  const double v = 2 / (9 * n);
  return (std::cbrt(chi_square / n) - (1 - v)) / std::sqrt(v);
}

double median_chi_square(double n) { return n * std::pow(1 - 2 / (9 * n), 3); }

double agreement(double chi_square, double n) {
  const double z = deviate(chi_square, n);
  return z > kKnee ? std::pow(kKnee / z, 4) : 1;
}

// Chi-square distances of the edges' ends.
std::vector<double> distances(const Controls& estimate,
                              const std::vector<Eigen::MatrixXd>& covariance,
                              const std::vector<PointEdge>& edges) {
  std::vector<double> out;
  for (const PointEdge& e : edges) {
    const Eigen::VectorXd difference = estimate.row(e.first) - estimate.row(e.second);
    const Eigen::MatrixXd both = covariance[static_cast<std::size_t>(e.first)] +
                                 covariance[static_cast<std::size_t>(e.second)];
    out.push_back(difference.dot(both.llt().solve(difference)));
  }
  return out;
}

Controls times(const GraphQuadratic& q, double strength, const Controls& u) {
  Controls out(u.rows(), u.cols());
  for (Eigen::Index p = 0; p < u.rows(); ++p)
    out.row(p) = u.row(p) * q.precision[static_cast<std::size_t>(p)];  // symmetric
  for (const PointEdge& e : q.edges) {
    const auto pull = (strength * e.weight * (u.row(e.first) - u.row(e.second))).eval();
    out.row(e.first) += pull;
    out.row(e.second) -= pull;
  }
  return out;
}

// Sum of the edges' weights at each point.
Eigen::VectorXd degrees(const GraphQuadratic& q) {
  Eigen::VectorXd degree = Eigen::VectorXd::Zero(q.centre.rows());
  for (const PointEdge& e : q.edges) degree[e.first] += e.weight, degree[e.second] += e.weight;
  return degree;
}

// Conjugate gradients on the entries that are free, the others stay as they are.
class FreeSolver {
 public:
  FreeSolver(const GraphQuadratic& q, double strength)
      : q_(q), strength_(strength), degree_(degrees(q)) {}

  void solve(const Mask& is_free, double most, Controls& u) {
    factor(is_free);
    Controls residual = masked(is_free, -gradient(q_, strength_, u));
    Controls step = precondition(residual), way = step;
    double product = residual.cwiseProduct(step).sum();
    const Eigen::Index max_steps = 20 * u.size() + 100;
    for (Eigen::Index i = 0; i < max_steps && residual.norm() > most; ++i) {
      const Controls image = masked(is_free, times(q_, strength_, way));
      const double length = product / way.cwiseProduct(image).sum();
      u += length * way;
      residual -= length * image;
      step = precondition(residual);
      const double next = residual.cwiseProduct(step).sum();
      way = step + next / product * way;
      product = next;
    }
  }

 private:
  static Controls masked(const Mask& is_free, const Controls& u) {
    return is_free.select(u.array(), 0.0).matrix();
  }

  void factor(const Mask& is_free) {
    block_.clear();
    for (Eigen::Index p = 0; p < is_free.rows(); ++p) {
      Eigen::MatrixXd block = q_.precision[static_cast<std::size_t>(p)];
      block.diagonal().array() += strength_ * degree_[p];
      for (Eigen::Index j = 0; j < block.rows(); ++j) {
        if (is_free(p, j)) continue;
        block.row(j).setZero();
        block.col(j).setZero();
        block(j, j) = 1;
      }
      block_.emplace_back(block);
    }
  }

  Controls precondition(const Controls& residual) const {
    Controls out(residual.rows(), residual.cols());
    for (Eigen::Index p = 0; p < residual.rows(); ++p)
      out.row(p) =
          block_[static_cast<std::size_t>(p)].solve(residual.row(p).transpose()).transpose();
    return out;
  }

  const GraphQuadratic& q_;
  double strength_;
  Eigen::VectorXd degree_;
  std::vector<Eigen::LLT<Eigen::MatrixXd>> block_;
};

// Largest violation of what holds at the minimum: no descent but into a bound.
double violation(const Controls& u, const Controls& slope) {
  return (u.array() > 0).select(slope.array().abs(), (-slope.array()).max(0.0)).maxCoeff();
}

// Each point in turn at its best, others held: never rises, ends at the minimum, but slowly.
void sweep_to_minimum(const GraphQuadratic& q, double strength, double most, Controls& u) {
  const Eigen::Index n = u.cols();
  const Eigen::VectorXd degree = degrees(q), zero = Eigen::VectorXd::Zero(n);
  std::vector<std::vector<std::pair<std::int32_t, double>>> beside(q.precision.size());
  for (const PointEdge& e : q.edges) {
    beside[static_cast<std::size_t>(e.first)].emplace_back(e.second, e.weight);
    beside[static_cast<std::size_t>(e.second)].emplace_back(e.first, e.weight);
  }
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    for (Eigen::Index p = 0; p < u.rows(); ++p) {
      const Eigen::MatrixXd& M = q.precision[static_cast<std::size_t>(p)];
      Eigen::VectorXd right = M * q.centre.row(p).transpose();
      for (const auto& [other, weight] : beside[static_cast<std::size_t>(p)])
        right += strength * weight * u.row(other).transpose();
      const Eigen::LLT<Eigen::MatrixXd> factor(M + strength * degree[p] *
                                                       Eigen::MatrixXd::Identity(n, n));
      const Eigen::MatrixXd root = factor.matrixU();
      u.row(p) = bounded_least_squares(root, factor.matrixL().solve(right), zero).transpose();
    }
    if (violation(u, gradient(q, strength, u)) <= most) return;
  }
}

}  // namespace

GraphQuadratic make_quadratic(const Controls& estimate,
                              const std::vector<Eigen::MatrixXd>& covariance,
                              std::vector<PointEdge> edges) {
  const Eigen::Index n = estimate.cols();
  const auto size = static_cast<double>(n);
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(n, n);
  std::vector<Eigen::MatrixXd> known;
  for (const Eigen::MatrixXd& c : covariance) known.push_back(c + kMinVariance * unit);
  GraphQuadratic q{estimate, {}, std::move(edges)};
  const std::vector<double> chi_square = distances(estimate, known, q.edges);
  if (q.edges.size() >= kFewestEdges)
    q.own_share = std::clamp(median(chi_square) / median_chi_square(size), kMinShare, 1.0);
  for (const Eigen::MatrixXd& c : known) q.precision.push_back(c.llt().solve(unit) / q.own_share);
  for (std::size_t e = 0; e < q.edges.size(); ++e)
    q.edges[e].weight *= agreement(chi_square[e] / q.own_share, size);
  return q;
}

Controls gradient(const GraphQuadratic& q, double strength, const Controls& u) {
  Controls out = times(q, strength, u);
  for (Eigen::Index p = 0; p < u.rows(); ++p)
    out.row(p) -= q.centre.row(p) * q.precision[static_cast<std::size_t>(p)];
  return out;
}

Controls bounded_minimum(const GraphQuadratic& q, double strength, const Controls& start,
                         double tolerance) {
  const double size = gradient(q, strength, q.centre).norm();
  if (!(size > 0)) return q.centre;
  const double most = tolerance * size;
  FreeSolver solver(q, strength);
  Controls u = start.cwiseMax(0.0);
  Mask is_free = u.array() > 0 || gradient(q, strength, u).array() <= 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    u = is_free.select(u.array(), 0.0).matrix();
    solver.solve(is_free, most, u);
    const Controls slope = gradient(q, strength, u);
    const Mask next = is_free.select(u.array() >= 0, slope.array() < -most);
    if ((next == is_free).all()) return u;
    is_free = next;
  }
  u = u.cwiseMax(0.0);
  sweep_to_minimum(q, strength, most, u);
  return u;
}

namespace {

using Sparse = Eigen::SparseMatrix<double>;

Sparse hessian(const GraphQuadratic& q, double strength) {
  const auto n = static_cast<int>(q.centre.cols());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t p = 0; p < q.precision.size(); ++p)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const int at = static_cast<int>(p) * n;
        entries.emplace_back(at + i, at + j, q.precision[p](i, j));
      }
  for (const PointEdge& e : q.edges)
    for (int j = 0; j < n; ++j) {
      const int a = e.first * n + j, b = e.second * n + j;
      const double pull = strength * e.weight;
      entries.emplace_back(a, a, pull);
      entries.emplace_back(b, b, pull);
      entries.emplace_back(a, b, -pull);
      entries.emplace_back(b, a, -pull);
    }
  Sparse H(static_cast<Eigen::Index>(q.precision.size()) * n,
           static_cast<Eigen::Index>(q.precision.size()) * n);
  H.setFromTriplets(entries.begin(), entries.end());
  return H;
}

// Z = (L D L')^-1 within the pattern of L, in place of L's entries; its diagonal in place of D's.
// Column j from the later ones: Z_sj = -Z_ss L_sj, Z_jj = 1 / D_j - L_sj' Z_sj, s the rows of
// column j, between which all entries are in the pattern.
void invert_within_pattern(Sparse& L, Eigen::VectorXd& diagonal) {
  const int size = static_cast<int>(L.cols());
  const int* const begin = L.outerIndexPtr();
  const int* const row = L.innerIndexPtr();
  double* const value = L.valuePtr();
  Eigen::VectorXd factor = Eigen::VectorXd::Zero(size), sum = Eigen::VectorXd::Zero(size);
  for (int j = size - 1; j >= 0; --j) {
    for (int at = begin[j]; at < begin[j + 1]; ++at)
      factor[row[at]] = value[at], sum[row[at]] = diagonal[row[at]] * value[at];
    // `factor` is 0 outside s; what `sum` gathers there is never looked at.
    for (int at = begin[j]; at < begin[j + 1]; ++at) {
      const int k = row[at];
      double own = 0;
      for (int in = begin[k]; in < begin[k + 1]; ++in) {
        own += value[in] * factor[row[in]];
        sum[row[in]] += value[in] * factor[k];
      }
      sum[k] += own;
    }
    double square = 1 / diagonal[j];
    for (int at = begin[j]; at < begin[j + 1]; ++at) {
      square += value[at] * sum[row[at]];
      value[at] = -sum[row[at]];
    }
    diagonal[j] = square;
    for (int at = begin[j]; at < begin[j + 1]; ++at) factor[row[at]] = 0;
  }
}

// The entry of a lower triangle without its diagonal.
double entry(const Sparse& Z, const Eigen::VectorXd& diagonal, int i, int j) {
  return i == j ? diagonal[i] : Z.coeff(std::max(i, j), std::min(i, j));
}

}  // namespace

std::vector<Eigen::MatrixXd> posterior_covariance(const GraphQuadratic& q, double strength) {
  const Eigen::SimplicialLDLT<Sparse> factor(hessian(q, strength));
  Sparse Z = factor.matrixL().nestedExpression();
  Z = Z.triangularView<Eigen::StrictlyLower>();
  Eigen::VectorXd diagonal = factor.vectorD();
  invert_within_pattern(Z, diagonal);
  const auto& place = factor.permutationP().indices();
  const auto n = static_cast<int>(q.centre.cols());
  std::vector<Eigen::MatrixXd> blocks;
  for (int p = 0; p < q.centre.rows(); ++p) {
    Eigen::MatrixXd block(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        block(i, j) = entry(Z, diagonal, place[p * n + i], place[p * n + j]);
    blocks.push_back(block);
  }
  return blocks;
}

}  // namespace palpate::fit
