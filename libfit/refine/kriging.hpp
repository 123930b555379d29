#pragma once

#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// A number that was measured, with errors, at points of a surface, at other places of it (M12f):
/// ordinary kriging. Covariances fall with the distance, and with the angle between normals, so
/// that the other side of a thin part is far. Of 32 of them (range, share of the angle, nugget)
/// each counts with its restricted likelihood (Patterson and Thompson 1971), so that few points do
/// not decide by chance (of more than 300 points an even share judges). O(P^3); deterministic.
class Kriging {
 public:
  /// position, normal: P x 3 [m], unit; no normals: distances alone count, there and below.
  /// value: P. Three points or more.
  Kriging(const Points& position, const Points& normal, const Eigen::VectorXd& value);

  /// At places Q x 3 with normals Q x 3; at a point itself without what its nugget smooths. Q.
  Eigen::VectorXd at(const Points& position, const Points& normal) const;

  /// P: at each point from the others (Dubrule 1983).
  const Eigen::VectorXd& left_out() const { return left_out_; }

 private:
  struct Covariance {
    double range_m, turn_m, nugget;
  };
  struct KeptCovariance {
    Covariance covariance;
    double share, mean;
    Eigen::VectorXd weight;  // P, of the covariances with the points
  };
  struct FittedCovariance;
  static Eigen::MatrixXd between(const Covariance& covariance, const Points& a,
                                 const Points& a_normal, const Points& b, const Points& b_normal);

  static FittedCovariance fitted(const Covariance& covariance, const Points& position,
                                 const Points& normal, const Eigen::VectorXd& value);

  Points position_, normal_;
  std::vector<KeptCovariance> kept_;
  Eigen::VectorXd left_out_;
};

}  // namespace palpate
