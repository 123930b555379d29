#pragma once

#include <vector>

#include "libfit/runtime/base/spline.hpp"

namespace palpate {

/// A shared spline basis of one curve kind (docs/method.md, section 3).
/// Clamped B-splines of `degree` (1 to 4) over strictly increasing `knots_m` (first 0 [m]). A curve
/// is f(x) = sum_j b_j B_j(x), `size()` = pieces + degree control values b_j [N], with b_0 = 0 (so
/// f(0) = 0 exactly) and b_j <= b_{j+1} (so f' >= 0 exactly). The increments b_{j+1} - b_j >= 0 are
/// the coefficients of the I-spline basis (Ramsay 1988, doi:10.1214/ss/1177012761). Below 0 a curve
/// is 0; past the last knot it goes on along its last slope.
struct CurveBasis {
  int degree = 3;
  std::vector<double> knots_m;

  int pieces() const { return static_cast<int>(knots_m.size()) - 1; }
  int size() const { return pieces() + degree; }
};

/// A basis as numbers the engine evaluates: polynomials per interval, laid out as one block.
/// Interval i < pieces is [knots[i], knots[i+1]); interval `pieces` is the linear continuation.
/// With t = x - knots[i], local basis k (0..degree) belongs to control value b_{i+k}
/// (b_{pieces-1+k} in the continuation) and is  sum_m weights[((i*(degree+1)) + k)*(degree+1) + m]
/// t^m. integrals[i*size + j] = integral of B_j from 0 to knots[i] [m], i = 0..pieces.
struct SplineTables {
  int degree = 0;
  int pieces = 0;
  std::vector<double> knots;      ///< pieces + 1 [m]
  std::vector<double> weights;    ///< (pieces + 1) x (degree + 1) x (degree + 1)
  std::vector<double> integrals;  ///< (pieces + 1) x size
};

/// Tables as the engine's templates read them. Not valid after `tables` is gone.
inline runtime::SplineView view(const SplineTables& tables) {
  return {tables.degree, tables.pieces, tables.knots.data(), tables.weights.data(),
          tables.integrals.data()};
}

/// Greville abscissa of control value j: the mean of the knots between the ends of B_j.
double greville_m(const CurveBasis& basis, int j);

/// Throws Error when the degree is not 1..4, there are fewer than 2 knots, the first is not 0, or
/// knots do not increase by at least 1e-9 of their range (de Boor 1978, chapter X).
SplineTables tabulate(const CurveBasis& basis);

}  // namespace palpate
