#include "libfit/io/files/files.hpp"

#include <fmt/core.h>

#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr const char* kCurvesHash = "curves_hash";

std::string hash_of_file(const std::filesystem::path& path) {
  return ContentHash().add_file(path).hex();
}

std::string own_name(std::size_t kind, std::string_view column) {
  return fmt::format("curves/{}/own_{}", kCurveNames[kind], column);
}

FitCache read_checked(const Reader& reader, const FittedCurves& curves) {
  FitCache cache;
  cache.fingerprint = reader.strings("points/fingerprint", curves.name.size());
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!(curves.smoothing[kind] > 0)) continue;
    const CurveBasis& basis = curves.curves.basis[kind];
    const Controls& covariance = curves.covariance[kind];
    cache.own_control[kind] =
        read_table(reader, own_name(kind, "controls"), "N", curves.position.rows(), basis.size());
    cache.own_covariance[kind] = read_table(reader, own_name(kind, "covariance"), "N^2",
                                            covariance.rows(), covariance.cols(), true);
    check_controls(complain_about(reader), own_name(kind, "controls"),
                   parts_of(curves.curves.family)[kind], cache.own_control[kind], basis,
                   curves.position.rows());
  }
  return cache;
}

}  // namespace

std::filesystem::path fit_cache_path(const std::filesystem::path& curves_path) {
  return curves_path.string() + ".warm";
}

std::optional<FitCache> read_fit_cache(const std::filesystem::path& curves_path,
                                       const FittedCurves& curves) {
  try {
    const Reader reader = open(fit_cache_path(curves_path), kFitCacheSchema);
    if (reader.text_attribute("", kCurvesHash) != hash_of_file(curves_path)) return std::nullopt;
    return read_checked(reader, curves);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void write_fit_cache(const std::filesystem::path& curves_path, const FitCache& cache) {
  Writer writer = create(fit_cache_path(curves_path), kFitCacheSchema,
                         {{kCurvesHash, hash_of_file(curves_path)}});
  writer.strings("points/fingerprint", cache.fingerprint);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (cache.own_control[kind].rows() == 0) continue;
    write_table(writer, own_name(kind, "controls"), "N", cache.own_control[kind]);
    write_table(writer, own_name(kind, "covariance"), "N^2", cache.own_covariance[kind]);
  }
  writer.commit();
}

}  // namespace palpate
