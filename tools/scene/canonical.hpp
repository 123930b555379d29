#pragma once

#include <string>
#include <utility>
#include <vector>

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Puts into the body what later stages need of a scene: its text with defaults filled in, without
/// [validate], the meshes of the files that it names, and its probe. Returns whether
/// that changed the body.
bool store_scene(const Scene& scene, Body& body);

/// The scene of a body, meshes read. Throws Error at `path` as parse_scene, or where a mesh is
/// missing.
Scene scene_of(const Body& body, const std::filesystem::path& path);

/// Canonical text of all that a stage's result depends on: TOML in SI, in one order. Two scenes
/// with equal text give equal results; comments, key order and spelling of units do not count.
/// Files count by name (their content is the fingerprint's), a mesh that is read by its content.
std::string canonical(const Scene& scene, Stage stage);
std::string canonical(const BodySection& section);
std::string canonical(const FitSection& section);
std::string canonical(const fem::MaterialParameters& material);
std::string canonical(const ProbeSpec& probe);
std::string canonical(const ToolSection& tool);

/// The numbers of a matrix, for a hash.
template <class Matrix>
std::string_view bytes_of(const Matrix& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()),
          static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar)};
}

/// Sections and keys of a scene that name files.
inline constexpr std::pair<const char*, const char*> kSceneFiles[] = {
    {"body", "surface"}, {"body", "tetmesh"}, {"probe", "mesh"}, {"experiments", "test_points"}};

/// A value of a section and how TOML writes it: {"material", "young", "\"2 kPa\""}.
struct NewValue {
  std::string section, key, value;
};

/// A text with some values of its sections replaced, all else kept byte by byte. A key that a
/// section lacks goes behind the line of its last one; a section that is missing is left out.
std::string rewritten(std::string text, const std::string& file,
                      const std::vector<NewValue>& values);

/// A text as a TOML string: TOML understands what JSON escapes, and how.
std::string quoted(const std::string& text);

/// The files that a scene names relative to itself, by absolute names, not quoted.
std::vector<NewValue> absolute_files(const std::string& text, const std::string& file);

}  // namespace palpate::tools
