// Compression of a cylinder between plates, as exported with a preamble "Name: value;" and a header
// Time (s),Compression (mm),Load (N),...: load and compression are positive when pressing.

#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::string_view kHeader = "Time (s),Compression (mm),Load (N)";

// "Cylinder Diameter: 50mm;" -> {"Cylinder Diameter", "50mm"}
void add_fact(std::string_view line, RawRecording& recording) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  std::string_view value = trimmed(line.substr(colon + 1));
  while (value.ends_with(';')) value.remove_suffix(1);
  recording.facts[std::string(trimmed(line.substr(0, colon)))] = std::string(trimmed(value));
}

}  // namespace

bool begins_instron(std::string_view head) { return head.find(kHeader) != std::string_view::npos; }

std::vector<RawRecording> read_instron(const std::filesystem::path& path, std::string_view bytes,
                                       const ReadSettings& settings) {
  ReadSettings own = settings;
  own.columns = {};
  own.columns.time = "Time (s)";
  own.columns.depth = "Compression (mm)";
  own.columns.force = {"Load (N)"};
  own.units = {};
  own.is_force_on_tool = false;
  own.separator = ',';
  own.decimal = '.';
  auto recordings = read_columns_csv(path, bytes, own);
  const TextFile file(path, bytes, settings.encoding);
  for (std::size_t i = 0; i < file.lines() && file.line(i).find(kHeader) == std::string_view::npos;
       ++i)
    add_fact(file.line(i), recordings.front());
  return recordings;
}

}  // namespace palpate::importers
