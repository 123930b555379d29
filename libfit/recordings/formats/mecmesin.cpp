// A test stand's text export: a title line with the maker's name, then Time;Load;Displacement with
// units in brackets, semicolons between, decimal commas; load is positive when pressing.

#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {

bool begins_mecmesin(std::string_view head) {
  return head.find("Mecmesin") != std::string_view::npos;
}

std::vector<RawRecording> read_mecmesin(const std::filesystem::path& path, std::string_view bytes,
                                        const ReadSettings& settings) {
  ReadSettings own = settings;
  own.columns = {};
  own.columns.time = "Time (s)";
  own.columns.depth = "Displacement (mm)";
  own.columns.force = {"Load (N)"};
  own.units = {};
  own.is_force_on_tool = false;
  own.separator = ';';
  own.decimal = ',';
  return read_columns_csv(path, bytes, own);
}

}  // namespace palpate::importers
