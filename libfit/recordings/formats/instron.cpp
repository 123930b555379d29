// Compression of a cylinder between plates, as exported with a preamble "Name: value;" and a header
// Time (s),Compression (mm),Load (N),...: load and compression are positive when pressing.

#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::string_view kHeader = "Time (s),Compression (mm),Load (N)";

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
  return read_columns_csv(path, bytes, own);
}

}  // namespace palpate::importers
