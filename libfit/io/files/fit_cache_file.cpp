#include "libfit/io/files/files.hpp"

#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr const char* kCurvesHash = "curves_hash";

std::string hash_of_file(const std::filesystem::path& path) {
  return ContentHash().add_file(path).hex();
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
    return FitCache{reader.strings("points/fingerprint", curves.name.size())};
  } catch (const Error&) {
    return std::nullopt;
  }
}

void write_fit_cache(const std::filesystem::path& curves_path, const FitCache& cache) {
  Writer writer = create(fit_cache_path(curves_path), kFitCacheSchema,
                         {{kCurvesHash, hash_of_file(curves_path)}});
  writer.strings("points/fingerprint", cache.fingerprint);
  writer.commit();
}

}  // namespace palpate
