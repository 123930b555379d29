// AFMWorkshop force-distance curve: a preamble with the place in a map, then extend and retract
// side by side; the retract columns begin at the deepest row. Force in nN, or a raw signal in V.

#include "libfit/core/units.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "libfit/recordings/formats/text_file.hpp"

namespace palpate::importers {
namespace {

constexpr std::string_view kBegin = "Force-Distance Curve";

std::map<std::string, std::string> preamble_of(const TextFile& file, std::size_t end) {
  std::map<std::string, std::string> facts;
  for (std::size_t i = 0; i < end; ++i)
    if (const std::size_t colon = file.line(i).find(':'); colon != std::string_view::npos)
      facts[std::string(trimmed(file.line(i).substr(0, colon)))] =
          std::string(trimmed(file.line(i).substr(colon + 1)));
  return facts;
}

// "X, um" and "Y, um": the place in the map, in its plane.
void place_by(const std::map<std::string, std::string>& facts, RawRecording& out) {
  std::optional<double> place[2];
  for (int k = 0; k < 2; ++k)
    if (const auto fact = facts.find(k == 0 ? "X, um" : "Y, um"); fact != facts.end())
      place[k] = parse_number(fact->second, '.');
  const double metre = *unit_factor("um", Dimension::length);
  if (place[0] && place[1]) place_in_plane(*place[0] * metre, *place[1] * metre, out);
}

}  // namespace

bool begins_afm_workshop(std::string_view head) { return head.starts_with(kBegin); }

std::vector<RawRecording> read_afm_workshop(const std::filesystem::path& path,
                                            std::string_view bytes, const ReadSettings& settings) {
  const TextFile file(path, bytes, settings.encoding);
  std::size_t header = 0;
  while (header < file.lines() && !file.line(header).starts_with("Extend Z-Sense")) ++header;
  if (header == file.lines())
    throw file.error("has no line `Extend Z-Sense(nm),...`", "Export the curve again.");
  std::vector<std::string> names;
  for (const auto name : split(file.line(header), ',')) names.emplace_back(name);
  if (names.size() < 4 || !names[2].starts_with("Retract"))
    throw file.error(header, "does not name four columns, extend and retract",
                     "Export the curve again.");
  const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(header, what, remedy);
  };
  TableLayout layout;
  layout.first = header + 1;
  layout.field = {0, 1, 2, 3};
  layout.name = names;
  layout.drop_invalid = settings.drop_invalid;
  layout.may_end_early = true;
  const NumberTable table = read_numbers(file, layout);

  RawRecording r;
  r.facts = preamble_of(file, header);
  place_by(r.facts, r);
  r.dropped_rows = table.dropped_rows;
  r.retract_begins = static_cast<Eigen::Index>(table.line.size());
  const double metre = factor_of({Meaning::depth, 0, names[0]}, names[0], {}, fail);
  std::vector<double> scanner_m, signal;
  for (const std::size_t part : {std::size_t{0}, std::size_t{2}}) {
    for (const double z : table.column[part]) scanner_m.push_back(z * metre);
    signal.insert(signal.end(), table.column[part + 1].begin(), table.column[part + 1].end());
    r.line.insert(r.line.end(), table.line.begin(), table.line.end());
  }
  const std::string unit = split_unit(names[1]).second;
  r.cantilever = settings.cantilever;
  if (unit == "V") {
    const Cantilever cantilever = cantilever_of(settings, {}, fail, r);
    bend_cantilever(cantilever, scanner_m, bent_by(cantilever, signal), r);
  } else {
    const double newton = factor_of({Meaning::force, 0, names[1]}, names[1], {}, fail);
    const double k = settings.cantilever ? settings.cantilever->stiffness_N_m : 0;
    for (std::size_t i = 0; i < signal.size(); ++i) {
      r.push_N.push_back(signal[i] * newton);
      r.travel_m.push_back(scanner_m[i] - (k > 0 ? (signal[i] - signal[0]) * newton / k : 0));
    }
    if (!(k > 0)) r.facts["cantilever"] = "not given: its bending is part of the depth";
  }
  return {r};
}

}  // namespace palpate::importers
