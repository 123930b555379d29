#pragma once

#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// What a mesh and a coarse grid say about the forces of one experiment, all relative to them.
/// excess: by how much forces on the mesh exceed those of an ever finer one, to be taken off.
/// error: bound of what is then left, per row; NaN where nothing can be compared.
struct Richardson {
  double excess = 0;
  std::vector<double> error;
};

/// Errors of opposite sign cancel in a mean. No bound below what they were found to be then, in a
/// body of one material; and where the border of another is within two contact radii, whose
/// elements differ from the border (soft and stiff lumps: tests/libfem/solve).
inline constexpr double kMinError = 0.003, kMinErrorAtBorder = 0.012;

/// Richardson extrapolation to elements of size zero of the rows of one experiment. fine, coarse:
/// forces [N] on the mesh and on a coarse grid whose elements are `ratio` times as large; zero
/// where a row failed. A mesh with size proportional to distance from first touch is too stiff by
/// nearly the same share at every depth, while differences of single rows scatter with how the rim
/// of the contact happens to cut elements: so excess is the mean of all rows, and a row's own
/// deviation from it only adds to its error (M13b, M13c). Forces below a hundredth of the largest
/// do not count for the mean. No extrapolation where the coarse grid is off by more than a tenth:
/// the error is then all of the difference. min_error: no bound is below it. Source: Richardson
/// 1911, doi:10.1098/rsta.1911.0009, with the order observed, 2.
Richardson richardson(const std::vector<Vec3>& fine, const std::vector<Vec3>& coarse, double ratio,
                      double min_error = kMinError);

}  // namespace palpate::fem
