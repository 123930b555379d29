#include "libfit/fit/basis/choose_degree.hpp"

#include <algorithm>
#include <limits>

#include "libfit/core/text.hpp"

namespace palpate::fit {
namespace {

constexpr int kByPreference[] = {3, 2, 4, 1};
constexpr double kAsGood = 1.1;  // of the least excess over the tolerance

struct Tried {
  int degree = 0, controls = 0;
  double worst_error = 0, excess = 0;  // of kinds that were judged; sum of what is above tolerance
};

Tried attempt(int degree, const BodyData& body, std::vector<PointRows>& rows, FitOptions options) {
  options.degree = degree;
  Tried out{degree, 0, 0, 0};
  int pieces = 0;
  for (const BasisReport& kind : choose_bases(body, rows, options)) {
    out.controls += kind.basis.size();
    pieces = std::max(pieces, kind.basis.pieces());
    out.worst_error = std::max(out.worst_error, kind.heldout_error);
    out.excess += std::max(0.0, kind.heldout_error - options.tolerance);
  }
  if (degree == 1 && pieces > 1) out.excess = std::numeric_limits<double>::infinity();
  return out;
}

}  // namespace

ChosenDegree choose_degree(const BodyData& body, std::vector<PointRows>& rows,
                           const FitOptions& options) {
  std::vector<Tried> tried;
  double least = std::numeric_limits<double>::infinity();
  for (const int degree : kByPreference) {
    tried.push_back(attempt(degree, body, rows, options));
    least = std::min(least, tried.back().excess);
  }
  const Tried* best = nullptr;
  ChosenDegree out;
  for (const Tried& t : tried) {
    out.reason += (out.reason.empty() ? "control values and largest held-out error: " : "; ") +
                  std::to_string(t.degree) + " " + std::to_string(t.controls) + ", " +
                  percent(t.worst_error);
    if (t.excess <= kAsGood * least && (best == nullptr || t.controls < best->controls)) best = &t;
  }
  out.degree = best->degree;
  return out;
}

}  // namespace palpate::fit
