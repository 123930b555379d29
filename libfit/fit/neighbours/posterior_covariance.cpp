#include <Eigen/SparseCholesky>

#include "libfit/fit/neighbours/graph_quadratic.hpp"

namespace palpate::fit {
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
