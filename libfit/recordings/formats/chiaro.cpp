// Nanoindenters of Optics11 (Chiaro, Piuma): latin-1, line ends in any mixture, a preamble and five
// or six columns, with the decimal sign of the computer's language. Files of 2020 and before name
// no device. The tip goes where the piezo goes, less what the cantilever bends; the file's own
// "Indentation" is that difference cut off at its contact point, so it is not used.

#include "libfit/core/units.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::string_view kHeader =
    "Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)";

// Every "name<tab>value" or "name: value" of the preamble.
std::map<std::string, std::string> preamble_of(const TextFile& file, std::size_t end) {
  std::map<std::string, std::string> facts;
  for (std::size_t i = 0; i < end; ++i) {
    const auto fields = split(file.line(i), '\t');
    for (std::size_t f = 0; f + 1 < fields.size(); f += 2)
      if (!fields[f].empty()) facts[std::string(fields[f])] = std::string(fields[f + 1]);
    const std::size_t colon = fields[0].find(':');
    if (fields.size() == 1 && colon != std::string_view::npos)
      facts[std::string(trimmed(fields[0].substr(0, colon)))] =
          std::string(trimmed(fields[0].substr(colon + 1)));
  }
  return facts;
}

std::optional<double> number_in(const std::map<std::string, std::string>& facts,
                                const std::string& name, char decimal) {
  const auto fact = facts.find(name);
  return fact == facts.end() ? std::nullopt : parse_number(fact->second, decimal);
}

// A comma where the first row of numbers has one.
char decimal_of(const TextFile& file, std::size_t first) {
  for (std::size_t i = first; i < file.lines(); ++i)
    if (!trimmed(file.line(i)).empty())
      return file.line(i).find(',') != std::string_view::npos ? ',' : '.';
  return '.';
}

}  // namespace

bool begins_chiaro(std::string_view head) {
  const auto has = [&](std::string_view words) {
    return head.find(words) != std::string_view::npos;
  };
  return has("Tip radius (um)") && (has("Chiaro") || has(kHeader) || has("Piezo Indentation"));
}

std::vector<RawRecording> read_chiaro(const std::filesystem::path& path, std::string_view bytes,
                                      const ReadSettings& settings) {
  const TextFile file(path, bytes, "latin-1");
  std::size_t header = 0;
  while (header < file.lines() && !file.line(header).starts_with(kHeader)) ++header;
  if (header == file.lines())
    throw file.error("has no header `" + std::string(kHeader.substr(0, 25)) + "...`",
                     "Export the indentation again as text.");
  TableLayout layout;
  layout.first = header + 1;
  layout.separator = '\t';
  layout.decimal = decimal_of(file, layout.first);
  layout.field = {0, 1, 3, 4};
  layout.name = {"Time (s)", "Load (uN)", "Cantilever (nm)", "Piezo (nm)"};
  layout.drop_invalid = settings.drop_invalid;
  NumberTable table = read_numbers(file, layout);

  RawRecording r;
  r.facts = preamble_of(file, header);
  r.line = std::move(table.line);
  r.dropped_rows = table.dropped_rows;
  r.time_s = std::move(table.column[0]);
  const double newton = *unit_factor("uN", Dimension::force),
               metre = *unit_factor("nm", Dimension::length);
  for (std::size_t i = 0; i < r.line.size(); ++i) {
    r.push_N.push_back(table.column[1][i] * newton);
    r.travel_m.push_back((table.column[3][i] - table.column[2][i]) * metre);
  }
  if (const auto radius = number_in(r.facts, "Tip radius (um)", layout.decimal);
      radius && *radius > 0)
    r.probe_radius_m = *radius * *unit_factor("um", Dimension::length);
  const double micrometre = *unit_factor("um", Dimension::length);
  const auto x = number_in(r.facts, "X-position (um)", layout.decimal),
             y = number_in(r.facts, "Y-position (um)", layout.decimal);
  if (x && y) place_in_plane(*x * micrometre, *y * micrometre, r);
  return {r};
}

}  // namespace palpate::importers
