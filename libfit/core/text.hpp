#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// A number for people: digits significant ones at most, as printf's %g.
std::string number(double value, int digits = 3);
/// 0.0213 is "2.1 %".
std::string percent(double share, int decimals = 1);
/// 0.00213 is "2.13 mm".
std::string millimetres(double length_m);
/// "1 edge" or "3 edges".
std::string counted(std::int64_t count, std::string_view one, std::string_view several);
/// "(0.01, 0.02, 0) m".
std::string coordinates(const Vec3& point_m);
/// "file.csv:12".
std::string file_line(std::string_view file, std::size_t line);
/// Texts one after another.
std::string listed(std::span<const std::string> texts, std::string_view separator = ", ");
/// Without blanks and tabs at its ends.
std::string_view trimmed(std::string_view text);
/// Appends a sentence to a message.
void add_sentence(std::string& message, std::string_view sentence);
/// The shortest digits that read back as the same double.
std::string to_text(double value);

/// 64-bit hash of bytes: tells content that changed from content that did not. It is no defence
/// against forgery. A hash given as `seed` makes a chain: the result depends on all links and on
/// where each ends. Source: XXH3 of libxxhash, Collet 2020.
std::uint64_t hash_of(std::string_view bytes, std::uint64_t seed = 0);

/// 16 hex digits.
std::string hex16(std::uint64_t hash);

}  // namespace palpate
