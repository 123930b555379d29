#pragma once

#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Comparison of a mesh with a coarse grid by the forces of one experiment, all relative to them.
/// excess: by how much forces on the mesh exceed those of an ever finer one, to be taken off.
/// error: of what is then left, per row, at 95 %; NaN where nothing can be compared.
struct Richardson {
  double excess = 0;
  std::vector<double> error;
};

/// Errors that grids which agree have in common: forces of balls and cones on exact layers are up
/// to 1.1 % off (tests/validation/contact), and 1.2 % where the border of another material, whose
/// elements differ from it, is within two contact radii (soft and stiff lumps: tests/libfem/solve).
inline constexpr double kMinError = 0.01, kMinErrorAtBorder = 0.012;

/// Richardson extrapolation to elements of size zero of the rows of one experiment. fine, coarse:
/// forces [N] on the mesh and on a coarse grid whose elements are `ratio` times as large; zero
/// where a row failed. A mesh with size proportional to distance from first touch is too stiff by
/// nearly the same share at every depth, while differences of single rows scatter with how the rim
/// of the contact happens to cut elements: so excess is the mean of all rows, and a row's own
/// deviation from it, sideways too, only adds to its error, in quadrature to half of the excess
/// (M13b, M13c). Forces below a hundredth of the largest do not count for the mean. No
/// extrapolation where the coarse grid is off by more than a tenth: the error is then all of the
/// difference. min_error: no error is below it. Source: Richardson 1911,
/// doi:10.1098/rsta.1911.0009, with the order observed, 2.
Richardson richardson(const std::vector<Vec3>& fine, const std::vector<Vec3>& coarse, double ratio,
                      double min_error = kMinError);

}  // namespace palpate::fem
