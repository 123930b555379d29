#include "libfit/core/curves.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr int kMaxOrder = 5;  // degree 4
using Polynomial = std::array<double, kMaxOrder>;

void check(const CurveBasis& basis) {
  const auto& knots = basis.knots_m;
  if (basis.degree < 1 || basis.degree > 4)
    throw Error("curve basis", "degree " + std::to_string(basis.degree) + " is not 1 to 4",
                "Choose a degree of 1, 2, 3 or 4.");
  if (knots.size() < 2 || knots.front() != 0.0)
    throw Error("curve basis", "knots must start at 0 and hold at least one piece",
                "Give at least two knots, the first 0.");
  for (std::size_t i = 1; i < knots.size(); ++i)
    if (!(knots[i] - knots[i - 1] > 1e-9 * knots.back()) || !std::isfinite(knots[i]))
      throw Error("curve basis", "knot " + std::to_string(i) + " does not lie above the one before",
                  "Merge repeated knots and sort them.");
}

// Local polynomials in t = x - knots[piece] of the degree+1 B-splines alive on a piece, by the
// Cox-de Boor recursion carried out on coefficients.
std::array<Polynomial, kMaxOrder> local_polynomials(const CurveBasis& basis, int piece) {
  const int pieces = basis.pieces();
  const auto knot = [&](int i) {  // knot i of the clamped sequence, relative to the piece's start
    return basis.knots_m[i < 0 ? 0 : (i > pieces ? pieces : i)] - basis.knots_m[piece];
  };
  std::array<Polynomial, kMaxOrder> current{};
  current[0][0] = 1;
  for (int d = 1; d <= basis.degree; ++d) {
    std::array<Polynomial, kMaxOrder> next{};
    for (int k = 0; k < d; ++k) {  // spline k of degree d-1 lives on knots piece-d+1+k .. piece+1+k
      const double lo = knot(piece - d + 1 + k), hi = knot(piece + 1 + k);
      const double scale = 1 / (hi - lo);
      for (int m = 0; m < d; ++m) {
        const double c = scale * current[k][m];
        next[k][m] += c * hi;
        next[k][m + 1] -= c;
        next[k + 1][m] -= c * lo;
        next[k + 1][m + 1] += c;
      }
    }
    current = next;
  }
  return current;
}

}  // namespace

SplineTables tabulate(const CurveBasis& basis) {
  check(basis);
  const int order = basis.degree + 1, pieces = basis.pieces(), size = basis.size();
  SplineTables tables{basis.degree, pieces, basis.knots_m, {}, {}};
  tables.weights.assign((pieces + 1) * order * order, 0.0);
  tables.integrals.assign((pieces + 1) * size, 0.0);
  for (int i = 0; i < pieces; ++i) {
    const auto local = local_polynomials(basis, i);
    const double h = basis.knots_m[static_cast<std::size_t>(i) + 1] - basis.knots_m[i];
    for (int j = 0; j < size; ++j)
      tables.integrals[(i + 1) * size + j] = tables.integrals[i * size + j];
    for (int k = 0; k < order; ++k) {
      double value = 0, slope = 0, power = 1;  // of spline k at the piece's end
      for (int m = 0; m < order; ++m) {
        const double c = local[k][m];
        tables.weights[(i * order + k) * order + m] = c;
        tables.integrals[(i + 1) * size + i + k] += c * power * h / (m + 1);
        value += c * power;
        if (m + 1 < order) slope += (m + 1) * power * local[k][static_cast<std::size_t>(m) + 1];
        power *= h;
      }
      if (i + 1 == pieces) {
        tables.weights[(pieces * order + k) * order] = value;
        tables.weights[(pieces * order + k) * order + 1] = slope;
      }
    }
  }
  return tables;
}

double greville_m(const CurveBasis& basis, int j) {
  double sum = 0;  // the outer knots count `degree` times
  for (int k = 1; k <= basis.degree; ++k)
    sum += basis.knots_m[std::clamp(j + k - basis.degree, 0, basis.pieces())];
  return sum / basis.degree;
}

}  // namespace palpate
