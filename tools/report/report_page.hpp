#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::tools {

/// The folder of a run as one JSON object for the page (docs/formats/report.md).
/// Each file of a run may be missing, not all of them. Throws Error where the folder is none of a
/// run or a file that is read is damaged.
std::string contents_of_folder(const std::string& folder);

/// The same of a scene that has not been run: its body, and sentences to be warned by.
std::string contents_of_set_up(const std::string& name, const Body& body,
                               const std::vector<std::string>& warnings);

/// The page that tools/page was built to, if it is there: of an installation in
/// ../share/palpate/page.html, of a build in page/page.html, relative to the program's folder. It
/// is no part of the program, so that Palpate builds without Node.
std::optional<std::filesystem::path> find_page();

/// The first bytes of a page, by which kind_of_file knows it.
inline constexpr std::string_view kPageKind = "<!doctype html><!-- palpate -->";

/// Writes the page with its data, completely or not at all. Throws Error where there is no page.
/// contents: JSON.
void write_page(const std::filesystem::path& output, const std::string& contents);

using Json = nlohmann::ordered_json;

/// Bytes as text (RFC 4648, section 4).
inline std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

/// Numbers as their bytes, little-endian: docs/formats/report.md, "Contents of a report".
template <class T>
std::string packed(const std::vector<T>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}
/// Entries of a matrix, row by row, or of a list, each as a T.
template <class T, class Values>
std::string packed_as(const Values& values) {
  std::vector<T> all;
  if constexpr (requires { values.rows(); })
    for (const auto& row : values.rowwise())
      for (const auto value : row) all.push_back(static_cast<T>(value));
  else
    for (const auto& value : values) all.push_back(static_cast<T>(value));
  return packed(all);
}

// Each adds to a report's object what the page shows of one file of a run (docs/formats/report.md,
// "Contents of a report"); what is to be known goes to `warnings`.

void add_body(Json& json, const Body& body);
void add_model(Json& json, const Model& model);
void add_curves(Json& json, const FittedCurves& fitted);
/// fitted: the curves of the samples' points, or null.
void add_samples(Json& json, const Samples& samples, const FittedCurves* fitted);
/// path: validation.csv of a run.
void add_held_out(Json& json, const std::filesystem::path& path);
/// After the statement, which the asset must carry, too.
void add_asset(Json& json, const std::filesystem::path& path);

}  // namespace palpate::tools
