#pragma once

#include <span>
#include <string_view>

namespace palpate::importers {

/// A key of a recording's entry that some formats alone read.
struct FormatKey {
  std::string_view name;     ///< as in the manifest: "separator", "columns.normal"
  std::string_view formats;  ///< that read it, with blanks between
  std::string_view remedy;   ///< for other formats
};

std::span<const FormatKey> format_keys();

/// The key's row; nullptr of a key that every format reads.
const FormatKey* format_key(std::string_view name);
bool is_read_by(const FormatKey& key, std::string_view format);

}  // namespace palpate::importers
