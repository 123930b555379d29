#include "tools/stages/fingerprint.hpp"

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/describe.hpp"

namespace palpate::tools {
namespace {

// Raise a stage's number when its results change although its inputs do not.
constexpr const char* kBodyRevision = "body 1 " PALPATE_VERSION;
constexpr const char* kSamplesRevision = "samples 2 " PALPATE_VERSION;
constexpr const char* kCurvesRevision = "curves 2 " PALPATE_VERSION;
constexpr const char* kModelRevision = "model 1 " PALPATE_VERSION;
constexpr const char* kAssetRevision = "asset 1 " PALPATE_VERSION;
constexpr const char* kStatementRevision = "statement 2 " PALPATE_VERSION;

std::optional<std::string> inputs_in(const std::string& json) {
  const auto parsed = nlohmann::json::parse(json, nullptr, false);
  if (!parsed.is_object() || !parsed.contains(kInputsAttribute) ||
      !parsed[kInputsAttribute].is_string())
    return std::nullopt;
  return parsed[kInputsAttribute].get<std::string>();
}

template <class Matrix>
std::string_view bytes_of(const Matrix& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()),
          static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar)};
}

}  // namespace

std::string point_inputs(const Scene& scene, const Body& body) {
  ContentHash hash;
  hash.add(kSamplesRevision).add(canonical_point(scene));
  hash.add(bytes_of(body.surface.vertices)).add(bytes_of(body.surface.triangles));
  hash.add(bytes_of(body.volume.nodes)).add(bytes_of(body.volume.tets));
  hash.add(bytes_of(body.volume.region));
  hash.add({body.is_held.data(), body.is_held.size()});
  if (scene.probe.mesh) hash.add_file(*scene.probe.mesh);
  return hash.hex();
}

std::string body_inputs(const Scene& scene) {
  ContentHash hash;
  hash.add(kBodyRevision).add(canonical_body(scene));
  hash.add_file(scene.body.surface ? *scene.body.surface : *scene.body.tetmesh);
  if (scene.experiments.points_file) hash.add_file(*scene.experiments.points_file);
  return hash.hex();
}

std::string samples_inputs(const Scene& scene, const std::filesystem::path& body) {
  ContentHash hash;
  hash.add(kSamplesRevision).add(canonical_experiments(scene)).add_file(body);
  if (scene.probe.mesh) hash.add_file(*scene.probe.mesh);
  return hash.hex();
}

std::string curves_inputs(const Scene& scene, const std::filesystem::path& samples) {
  return ContentHash().add(kCurvesRevision).add(canonical_fit(scene)).add_file(samples).hex();
}

std::string model_inputs(const std::filesystem::path& curves, const std::filesystem::path& body) {
  return ContentHash().add(kModelRevision).add_file(curves).add_file(body).hex();
}

std::string asset_inputs(const Scene& scene, const std::filesystem::path& model) {
  return ContentHash().add(kAssetRevision).add(canonical_export(scene)).add_file(model).hex();
}

std::string statement_inputs(const Scene& scene, const std::string& asset_inputs,
                             const std::filesystem::path& body) {
  ContentHash hash;
  hash.add(kStatementRevision).add(canonical_validate(scene)).add(canonical_experiments(scene));
  hash.add(asset_inputs).add_file(body);
  if (scene.probe.mesh) hash.add_file(*scene.probe.mesh);
  return hash.hex();
}

std::optional<std::string> inputs_of_hdf5(const std::filesystem::path& path) {
  return attribute_of_hdf5(path, kInputsAttribute);
}

std::optional<std::string> attribute_of_hdf5(const std::filesystem::path& path, const char* name) {
  try {
    const Attributes attributes = read_attributes(path);
    const auto found = attributes.find(name);
    if (found != attributes.end()) return found->second;
  } catch (const Error&) {  // missing or damaged: made anew
  }
  return std::nullopt;
}

std::optional<std::string> inputs_of_asset(const std::filesystem::path& path) {
  try {
    return inputs_in(std::string(read_asset_file(path).meta_json()));
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool has_statement(const std::filesystem::path& asset) {
  try {
    const auto meta = nlohmann::json::parse(read_asset_file(asset).meta_json(), nullptr, false);
    return meta.is_object() && meta.contains("statement");
  } catch (const Error&) {
    return false;
  }
}

std::optional<std::string> inputs_of_json(const std::filesystem::path& path) {
  try {
    return inputs_in(read_whole_file(path));
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace palpate::tools
