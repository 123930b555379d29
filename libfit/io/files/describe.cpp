#include <algorithm>

#include "libfit/io/files/files.hpp"

namespace palpate {
namespace {

h5::Reader open_any(const std::filesystem::path& path) {
  return h5::Reader(path, "Name a file that `palpate` made.");
}

std::string known_schema(const h5::Reader& reader) {
  const std::string found =
      reader.has_attribute("", "schema") ? reader.text_attribute("", "schema") : "";
  const bool is_known = found == kSignalsSchema.name ||
                        std::any_of(kFileSchemas.begin(), kFileSchemas.end(),
                                    [&](const FileSchema& s) { return s.name == found; });
  if (!is_known)
    throw reader.error("", found.empty() ? "is an HDF5 file, but not one of Palpate's"
                                         : "holds `" + found + "`, which is unknown here");
  return found;
}

}  // namespace

std::string schema_of(const std::filesystem::path& path) { return known_schema(open_any(path)); }

Attributes read_attributes(const std::filesystem::path& path) {
  const h5::Reader reader = open_any(path);
  known_schema(reader);
  Attributes attributes = reader.root_texts();
  for (const auto* own : {"schema", "family"}) attributes.erase(own);
  return attributes;
}

FileDescription describe(const std::filesystem::path& path) {
  const h5::Reader reader = open_any(path);
  FileDescription description;
  description.schema = known_schema(reader);
  description.version = static_cast<int>(reader.integer_attribute("", "version"));
  description.attributes = reader.root_texts();
  description.attributes.erase("schema");
  for (const auto& name : reader.data_sets())
    description.data_sets.push_back(
        {name, reader.type_of(name), reader.shape_of(name), reader.unit_of(name)});
  return description;
}

}  // namespace palpate
