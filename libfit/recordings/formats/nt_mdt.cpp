// NT-MDT curve: no header, three columns with decimal commas: scanner height in nm (falling towards
// the sample), signal on the way in and on the way back in nA. Rows run from the deepest point
// upwards.

#include <algorithm>

#include "libfit/core/units.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "libfit/recordings/formats/text_file.hpp"

namespace palpate::importers {
namespace {

bool is_row(std::string_view line) {
  const auto fields = split(line, '\t');
  return fields.size() == 3 && std::all_of(fields.begin(), fields.end(), [](std::string_view f) {
           return f.find(',') != std::string_view::npos && parse_number(f, ',');
         });
}

}  // namespace

bool begins_nt_mdt(std::string_view head) {
  const std::size_t first = head.find_first_of("\r\n");
  if (first == std::string_view::npos) return false;
  const std::string_view rest =
      head.substr(std::min(head.find_first_not_of("\r\n", first), head.size()));
  return is_row(head.substr(0, first)) && is_row(rest.substr(0, rest.find_first_of("\r\n")));
}

std::vector<RawRecording> read_nt_mdt(const std::filesystem::path& path, std::string_view bytes,
                                      const ReadSettings& settings) {
  const TextFile file(path, bytes, settings.encoding);
  TableLayout layout;
  layout.separator = '\t';
  layout.decimal = ',';
  layout.field = {0, 1, 2};
  layout.name = {"#1", "#2", "#3"};
  layout.drop_invalid = settings.drop_invalid;
  const NumberTable table = read_numbers(file, layout);
  const double metre = *unit_factor("nm", Dimension::length);
  const std::size_t rows = table.line.size();
  RawRecording r;
  r.dropped_rows = table.dropped_rows;
  r.retract_begins = static_cast<Eigen::Index>(rows);
  std::vector<double> scanner_m, signal;
  for (std::size_t i = rows; i-- > 0;) {  // the way in: from far above down to the deepest row
    scanner_m.push_back(-table.column[0][i] * metre);
    signal.push_back(table.column[1][i]);
    r.line.push_back(table.line[i]);
  }
  for (std::size_t i = 0; i < rows; ++i) {
    scanner_m.push_back(-table.column[0][i] * metre);
    signal.push_back(table.column[2][i]);
    r.line.push_back(table.line[i]);
  }
  const Cantilever cantilever = cantilever_of(
      settings, {},
      [&](const std::string& what, const std::string& remedy) {
        return file.error(0, what, remedy);
      },
      r);
  bend_cantilever(cantilever, scanner_m, bent_by(cantilever, signal), r);
  return {r};
}

}  // namespace palpate::importers
