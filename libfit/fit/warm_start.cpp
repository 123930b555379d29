#include <cmath>
#include <initializer_list>
#include <unordered_map>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"

namespace palpate::fit {
namespace {

template <class T>
std::uint64_t mix(std::uint64_t hash, const T* values, std::size_t count) {
  return hash_of({reinterpret_cast<const char*>(values), count * sizeof(T)}, hash);
}

std::uint64_t mix(std::uint64_t hash, std::initializer_list<double> values) {
  return mix(hash, values.begin(), values.size());
}

// All that a fit reads of a row.
struct RowContent {
  double deflection_m[3], force_N[3], error_N;
  std::int32_t experiment, step, kind, status;
};
static_assert(sizeof(RowContent) == 7 * 8 + 4 * 4, "hashed byte by byte: no padding");

void mix_rows(const Samples& s, std::vector<std::uint64_t>& hash) {
  std::vector<std::int32_t> first_experiment(hash.size(), -1);
  for (std::size_t i = 0; i < s.point.size(); ++i) {
    const std::int32_t p = s.point[i];
    if (first_experiment[p] < 0) first_experiment[p] = s.experiment[i];
    RowContent row{{},
                   {},
                   s.force_error[i],
                   s.experiment[i] - first_experiment[p],
                   s.step[i],
                   static_cast<std::int32_t>(s.kind[i]),
                   static_cast<std::int32_t>(s.status[i])};
    for (int k = 0; k < 3; ++k) row.deflection_m[k] = s.deflection(i, k);
    for (int k = 0; k < 3; ++k) row.force_N[k] = s.force(i, k);
    hash[p] = mix(hash[p], &row, 1);
  }
}

// Whether the cache is there and belongs to the curves.
bool is_usable(const FitOptions& options) {
  const FittedCurves* earlier = options.warm_start;
  const FitCache* cache = options.warm_cache;
  return earlier != nullptr && cache != nullptr && earlier->covariance[0].size() > 0 &&
         earlier->deviation.size() == earlier->curves.control.size() &&
         cache->fingerprint.size() == earlier->status.size();
}

}  // namespace

std::vector<std::string> fingerprints(const Samples& samples, const BodyData& body,
                                      const BodyBases& bases, const FitOptions& options) {
  std::uint64_t common =
      mix(0, {options.default_friction, options.default_lateral_ratio, ball_radius_m(samples.probe),
              samples.probe ? samples.probe->friction : -1});
  if (bases.family == CurveFamily::rings) {
    const RingPrior& rings = bases.rings;
    for (const auto* numbers : {&rings.constant, &rings.slope, &rings.deviation})
      common = mix(common, numbers->data(), numbers->size());
    common = mix(common, {rings.is_of_drags ? 1.0 : 0.0, rings.log_force});
  }
  std::vector<std::uint64_t> hash(body.points.size(), common);
  mix_rows(samples, hash);
  std::vector<std::string> out;
  for (std::size_t p = 0; p < hash.size(); ++p) {
    const PointData& point = body.points[p];
    std::uint64_t& h = hash[p];
    for (int k = 0; k < 3; ++k)
      h = mix(h, {samples.point_position(p, k), samples.point_normal(p, k)});
    if (samples.point_normal_gradient.rows() > 0)
      for (int k = 0; k < 9; ++k) h = mix(h, {samples.point_normal_gradient(p, k)});
    if (!point.has_errors && point.problem.empty()) h = mix(h, {body.error_N});
    for (const PointExperiment& e : point.experiments)
      for (const Vec3& sway : e.sway) h = mix(h, sway.data(), 3);
    for (const PointExperiment& e : point.experiments)
      h = mix(h, {e.unknown[kContact] * body.length_m, e.unknown[kBias] * point.force_N,
                  e.unknown[kDrift] * point.force_N});
    out.push_back(hex16(h));
  }
  return out;
}

FitOptions as_before(FitOptions options) {
  const CurveSet& curves = options.warm_start->curves;
  options.degree = curves.basis[0].degree;
  for (std::size_t kind = 0; kind < curves_of(curves.family); ++kind) {
    if (curves.basis[kind].degree != options.degree)
      throw Error("warm start", "has curves of several degrees", "Fit without a warm start.");
    options.knots_m[kind] = curves.basis[kind].knots_m;
  }
  options.family = curves.family;
  options.sways = curves.family == CurveFamily::rings && !curves.control[runtime::kSway].isZero(0);
  return options;
}

std::vector<Eigen::Index> earlier_points(const FitOptions& options,
                                         const std::vector<std::string>& fingerprint) {
  std::vector<Eigen::Index> out(fingerprint.size(), -1);
  if (!is_usable(options)) return out;
  std::unordered_map<std::string_view, Eigen::Index> known;
  const std::vector<std::string>& before = options.warm_cache->fingerprint;
  for (std::size_t p = 0; p < before.size(); ++p) known.emplace(before[p], p);
  for (std::size_t p = 0; p < out.size(); ++p)
    if (const auto found = known.find(fingerprint[p]); found != known.end()) out[p] = found->second;
  return out;
}

}  // namespace palpate::fit
