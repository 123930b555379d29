#pragma once

#include <string>
#include <utility>
#include <vector>

namespace palpate::tools {

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

/// A text as a TOML string.
std::string quoted(const std::string& text);

/// The files that a scene names relative to itself, by absolute names, not quoted.
std::vector<NewValue> absolute_files(const std::string& text, const std::string& file);

}  // namespace palpate::tools
