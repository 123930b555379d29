#pragma once

#include <Eigen/Core>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/neighbours/point_graph.hpp"

// Estimates at the points of a graph under a Gaussian Markov random field (M19).

namespace palpate::fit {

/// E(u) = 1/2 sum_p (u_p - c_p)' M_p (u_p - c_p) + strength/2 sum_edges w |u_first - u_second|^2
/// over P points with n numbers each, all without dimension. Edges index the rows.
struct GraphQuadratic {
  Controls centre;                         ///< c, P x n
  std::vector<Eigen::MatrixXd> precision;  ///< M, P of n x n, positive definite
  std::vector<PointEdge> edges;
  double own_share = 1;  ///< of the covariances that is each point's own, see make_quadratic
};

/// From estimates, P x n, and their covariances, P of n x n. Where neighbours differ by less than
/// their covariances say (median chi-square distance over the edges, 8 at least), the rest is an
/// error that they have in common, such as what the basis cannot follow: averaging does not take it
/// off, and M is the inverse of the own share alone. Precisions are bounded by 1e8. An edge
/// whose ends differ by more than their noise explains (three standard deviations of the
/// chi-square distance, Wilson and Hilferty 1931, doi:10.1073/pnas.17.12.684) loses weight with the
/// fourth power of what is beyond, so that a lump keeps its border: an edge-preserving field.
GraphQuadratic make_quadratic(const Controls& estimate,
                              const std::vector<Eigen::MatrixXd>& covariance,
                              std::vector<PointEdge> edges);

/// dE/du, P x n.
Controls gradient(const GraphQuadratic& q, double strength, const Controls& u);

/// u >= 0 that minimises E, to `tolerance` of the gradient of the edges' part at the centre.
/// start: anything, for speed. Deterministic, one thread.
/// Source: primal-dual active sets, Hintermueller, Ito and Kunisch 2003,
/// doi:10.1137/S1052623401383558, on conjugate gradients with the diagonal blocks as
/// preconditioner; where the sets cycle, projected Gauss-Seidel over points.
Controls bounded_minimum(const GraphQuadratic& q, double strength, const Controls& start,
                         double tolerance);

/// Diagonal blocks, P of n x n, of (d2E/du2)^-1: the posterior covariance of each point's own share
/// without bounds, from the entries of the inverse within the pattern of its sparse Cholesky
/// factor. Source: Takahashi, Fagan and Chen 1973; Rue and Held, Gaussian Markov Random Fields
/// (2005), 2.4.
std::vector<Eigen::MatrixXd> posterior_covariance(const GraphQuadratic& q, double strength);

}  // namespace palpate::fit
