#pragma once

#include <optional>
#include <string_view>

#include "libfem/mesh/read/cursor.hpp"

namespace palpate::mesh_read {

/// <name attributes> or </name>.
struct XmlTag {
  std::string_view name;
  std::string_view attributes;
  bool is_end = false;     ///< </name>
  bool is_closed = false;  ///< <name/>
  std::size_t after = 0;   ///< byte after the tag
};

/// The next tag from the cursor's position, which moves past it; none when there is no more.
/// Passes over text, comments and processing instructions. Safe on untrusted bytes. This is all of
/// XML that VTK needs; its appended raw bytes are no XML, so a general parser would refuse them.
std::optional<XmlTag> next_tag(Cursor& file);

/// Value of an attribute of the tag; empty when it has none.
std::string_view attribute(const XmlTag& tag, std::string_view name);

}  // namespace palpate::mesh_read
