#pragma once

#include "libfit/fit/basis/choose_basis.hpp"

namespace palpate::fit {

/// Degree of the body's curves, 1 to 4, and why.
struct ChosenDegree {
  int degree = 3;
  std::string reason;  ///< a sentence
};

/// The degree whose bases, chosen as for any other, describe the body with the fewest control
/// values: of those whose held-out errors exceed the tolerance by little more than the least do.
/// Degree 1 only where every curve is one straight piece, so curves stay smooth. rows: as for
/// choose_bases. options.degree is not read.
ChosenDegree choose_degree(const BodyData& body, std::vector<PointRows>& rows,
                           const FitOptions& options);

}  // namespace palpate::fit
