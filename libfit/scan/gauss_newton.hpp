#pragma once

#include <vector>

#include "libfit/core/progress.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/scan/residuals.hpp"

namespace palpate::scan {

using Mask = std::vector<char>;  ///< of each row; rows of a pass have one

/// Squares of the mesh along the side of a square of nodes. At 1 heights of a dome of 20 mm are off
/// by 0.08 mm between nodes 3.6 mm apart, at 2 by 0.02. Passes left out of a robot's rows have a
/// loss 9 % higher at 1, and the same at 4.
inline constexpr int kParts = 2;

/// Least squares of the relative errors of all forces over the numbers at the nodes and those of
/// recording and body that are free, with Huber's loss and a weak prior of smoothness.
class ScanIdentification {
 public:
  /// body: its surface in the scan's frame, on which heights lie and stay; null: they are free.
  ScanIdentification(const Samples& scans, int jobs, const Progress& progress, const Surface* body);

  /// Gauss-Newton on the rows that are marked, damped where a step does not lower the loss. Ends
  /// early when Progress says so.
  void fit(const Mask& mask, int most_steps);
  /// Mean loss, and errors of rows above a tenth of the largest force.
  double loss_of(const Mask& mask) const;
  RelativeErrors errors(const Mask& mask) const;
  /// Standard errors of the numbers of Recording from the last fit; 0 of those that are not free.
  Eigen::VectorXd deviations(const Walked& walked) const;

  PlayedBody body() const { return PlayedBody(nodes, parameters, basis, kParts); }
  Walked walk(const Mask& mask) const { return body().walk(passes, mask, false, jobs_); }

  const Passes passes;
  const Nodes nodes;
  Unknowns unknowns;
  CurveBasis basis;
  ScanParameters parameters;
  Mask is_free;           ///< of each unknown
  double smoothness = 1;  ///< factor of the prior

 private:
  void start(const Surface* body);
  double loss(const Eigen::VectorXd& error, double scale, const Mask& mask) const;
  Eigen::VectorXd relative_errors(const Walked& walked) const;
  void update_changes(const Eigen::VectorXd& x, const Walked& walked, const Mask& mask,
                      std::map<int, Points>& changes) const;
  Eigen::VectorXd bounded_step(const ScanEquations& normal, const Eigen::VectorXd& room) const;

  int jobs_;
  const Progress& progress_;
  Eigen::VectorXd force_N_;
  double floor_N_ = 0, scale_ = 0;
  ScanEquations normal_;
};

}  // namespace palpate::scan
