#pragma once

#include <Eigen/Sparse>
#include <map>

#include "libfit/scan/walk.hpp"

namespace palpate::scan {

/// Places of the unknowns in one vector. All are of order 1: increments over `force_N`, heights
/// over the spacing of nodes, mu_1 times `depth_m`. Behind those of the nodes stand the numbers of
/// Recording.
struct Unknowns {
  int nodes = 0, increments = 0;
  double spacing_m = 0, depth_m = 0, force_N = 0;

  int increment(int node, int j) const { return node * increments + j; }
  int height(int node) const { return nodes * increments + node; }
  int friction(int node) const { return nodes * (increments + 1) + node; }
  int friction_slope(int node) const { return nodes * (increments + 2) + node; }
  int shared(int k) const { return nodes * (increments + 3) + k; }
  int size() const { return shared(kShared); }

  Eigen::VectorXd vector_of(const ScanParameters& p) const;
  ScanParameters parameters_of(const Eigen::VectorXd& x) const;
  /// Bounds from below; -infinity where there is none.
  Eigen::VectorXd lower() const;
};

/// Normal equations of Gauss-Newton: matrix dx = right.
struct ScanEquations {
  Eigen::SparseMatrix<double> matrix;
  Eigen::VectorXd right;
};

/// Linearises the forces of rows about the contact points that they have now: anchors and dashpots
/// hold, rings that slip stay at their limit. weight: N, of each row's residual; 0 leaves it out.
/// changes: of free numbers of Recording, the change of all readings by each, N x 3.
ScanEquations linearise(const Nodes& nodes, const Unknowns& unknowns, const PlayedBody& body,
                        const Walked& walked, const Passes& passes, const ScanParameters& at,
                        const Eigen::VectorXd& weight, const std::map<int, Points>& changes);

}  // namespace palpate::scan
