// Whole arrays. Variables of a MATLAB file that the manifest names: "force", or "M(:,2)" for a
// column of a matrix. Version 5 to 7 is read here (variables packed or not, without structures and
// cells); version 7.3 is HDF5, with rows and columns exchanged. Debian's libmatio returns numbers
// of files that are cut short or damaged, without an error. Source: MATLAB MAT-File Format, 2019.

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <functional>

#include "libfit/core/text.hpp"
#include "libfit/io/hdf5/hdf5.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::size_t kTag = 8;
constexpr std::string_view kVersion5 = "MATLAB 5.0 MAT-file", kVersion73 = "MATLAB 7.3 MAT-file";
constexpr int kPacked = 15;  // kind of an element
constexpr const char* kDamaged = "is a damaged MATLAB file";

template <class T>
double number_at(const char* bytes, bool is_swapped) {
  char copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof(T));
  if (is_swapped) std::reverse(copy, copy + sizeof(T));
  T value;
  std::memcpy(&value, copy, sizeof(T));
  return static_cast<double>(value);
}

// Storage of an element's numbers, by its kind.
struct Storage {
  int kind;
  std::size_t bytes;
  double (*read)(const char*, bool);
};
constexpr Storage kStorages[] = {
    {1, 1, number_at<std::int8_t>},   {2, 1, number_at<std::uint8_t>},
    {3, 2, number_at<std::int16_t>},  {4, 2, number_at<std::uint16_t>},
    {5, 4, number_at<std::int32_t>},  {6, 4, number_at<std::uint32_t>},
    {7, 4, number_at<float>},         {9, 8, number_at<double>},
    {12, 8, number_at<std::int64_t>}, {13, 8, number_at<std::uint64_t>}};

// An array of a file, whose numbers come row by row or column by column; a vector has one column.
struct NamedArray {
  std::string name, header;  // the second with its unit, where the file says one
  std::size_t rows = 0, columns = 0;
  bool is_row_major = false;
  std::function<std::vector<double>()> values;  // none of an array of another kind
};

NamedArray by_columns(const std::string& name, std::size_t rows, std::size_t columns,
                      std::function<std::vector<double>()> values) {
  if (rows == 1) std::swap(rows, columns);
  return {name, name, rows, columns, false, std::move(values)};
}

// A file of arrays.
struct ArrayFile {
  std::filesystem::path path;
  std::string noun;  // of an array
  std::vector<std::string> names;
  std::function<std::optional<NamedArray>(const std::string& name)> find;

  Error error(const std::string& name, const std::string& what, const std::string& remedy) const {
    return Error(path.string() + (name.empty() ? "" : ":" + name), what, remedy);
  }
  std::string listed_names() const { return "There are: " + listed(names).substr(0, 300) + "."; }
};

// The elements of version 5 one after another. Safe on untrusted bytes.
class MatElements {
 public:
  MatElements(std::string_view bytes, bool is_swapped, const std::filesystem::path& path)
      : rest_(bytes), is_swapped_(is_swapped), path_(path) {}

  struct MatElement {
    int kind = 0;
    std::string_view data;
  };
  bool is_at_end() const { return rest_.size() < kTag; }
  MatElement next() {
    if (is_at_end()) throw damaged();
    const std::uint32_t word = number(0), size = number(4);
    MatElement element;
    if (word >> 16) {  // a small one: its data is in the tag
      element.kind = static_cast<int>(word & 0xffff);
      if (word >> 16 > 4) throw damaged();
      element.data = rest_.substr(4, word >> 16);
      rest_.remove_prefix(kTag);
      return element;
    }
    element.kind = static_cast<int>(word);
    if (size > rest_.size() - kTag) throw damaged();
    element.data = rest_.substr(kTag, size);
    const std::size_t padded = element.kind == kPacked ? size : (std::size_t{size} + 7) / 8 * 8;
    rest_.remove_prefix(std::min(kTag + padded, rest_.size()));
    return element;
  }
  Error damaged() const { return Error(path_.string(), kDamaged, "Save it again."); }
  bool is_swapped() const { return is_swapped_; }

 private:
  std::uint32_t number(std::size_t at) const {
    return static_cast<std::uint32_t>(number_at<std::uint32_t>(rest_.data() + at, is_swapped_));
  }

  std::string_view rest_;
  bool is_swapped_;
  std::filesystem::path path_;
};

// The content of a matrix element.
NamedArray variable_of(MatElements parts) {
  const auto flags = parts.next(), sizes = parts.next(), name = parts.next();
  if (flags.data.size() < 4 || sizes.data.size() % 4 != 0) throw parts.damaged();
  const auto word =
      static_cast<std::uint32_t>(number_at<std::uint32_t>(flags.data.data(), parts.is_swapped()));
  const int array_class = static_cast<int>(word & 0xff);  // 6 to 15 are of numbers
  NamedArray other;
  other.name = std::string(name.data);
  const bool is_complex = (word >> 8) & 8;
  if (array_class < 6 || array_class > 15 || is_complex || sizes.data.size() != 8) return other;
  const auto numbers = parts.next();
  const auto* storage = std::ranges::find(kStorages, numbers.kind, &Storage::kind);
  const auto size = [&](std::size_t k) {
    return std::size_t(number_at<std::uint32_t>(sizes.data.data() + 4 * k, parts.is_swapped()));
  };
  if (storage == std::end(kStorages) || size(0) > numbers.data.size() ||
      size(1) > numbers.data.size() || size(0) * size(1) != numbers.data.size() / storage->bytes)
    throw parts.damaged();
  return by_columns(other.name, size(0), size(1),
                    [data = numbers.data, of = *storage, swap = parts.is_swapped()] {
                      std::vector<double> values(data.size() / of.bytes);
                      for (std::size_t i = 0; i < values.size(); ++i)
                        values[i] = of.read(data.data() + i * of.bytes, swap);
                      return values;
                    });
}

// All variables of a file of version 5; `unpacked` keeps what they point to.
std::vector<NamedArray> variables_5(const std::filesystem::path& path, std::string_view bytes,
                                    std::uintmax_t max_bytes, std::deque<std::string>& unpacked) {
  if (bytes.size() < 128) throw Error(path.string(), kDamaged, "Save it again.");
  const bool is_little = bytes.substr(126, 2) == "IM";
  const bool is_swapped = is_little != (std::endian::native == std::endian::little);
  std::vector<NamedArray> variables;
  MatElements elements(bytes.substr(128), is_swapped, path);
  while (!elements.is_at_end()) {
    auto element = elements.next();
    if (element.kind == kPacked) {
      unpacked.push_back(inflated(path, element.data, max_bytes, kDamaged));
      max_bytes -= unpacked.back().size();
      element = MatElements(unpacked.back(), is_swapped, path).next();
    }
    if (element.kind == 14)  // a matrix
      variables.push_back(variable_of(MatElements(element.data, is_swapped, path)));
  }
  return variables;
}

std::vector<double> values_of(const h5::Reader& file, const std::string& set, h5::Shape shape) {
  if (file.type_of(set).starts_with("float")) return file.numbers(set, h5::kAnyUnit, shape, true);
  const auto whole = file.integers(set, h5::kAnyUnit, shape);
  return {whole.begin(), whole.end()};
}

// "M(:,2)": {"M", 2}; "t": {"t", 0}.
std::pair<std::string, std::size_t> array_and_column(const std::string& name) {
  const std::size_t open = name.find("(:,");
  if (open == std::string::npos || !name.ends_with(')')) return {name, 0};
  const auto column = parse_number(name.substr(open + 3, name.size() - open - 4), '.');
  if (!column || !(*column >= 1) || *column > 1e6) return {name, 0};
  return {name.substr(0, open), static_cast<std::size_t>(*column)};
}

// The numbers of a column by its name, and the header that says their unit.
std::vector<double> column_of(const ArrayFile& file, const std::string& name, std::string& header) {
  const auto [of, column] = array_and_column(name);
  const auto found = file.find(of);
  if (!found) throw file.error(name, file.noun + " is missing", file.listed_names());
  if (!found->values || found->rows * found->columns == 0)
    throw file.error(name, "is no array of real numbers", file.listed_names());
  if (column == 0 && found->columns > 1)
    throw file.error(name, fmt::format("is a matrix of {} columns", found->columns),
                     "Name one of them: \"" + of + "(:,1)\".");
  if (column > found->columns)
    throw file.error(name, fmt::format("has {} columns", found->columns),
                     "Name one that is there.");
  header = found->header;
  const std::vector<double> all = found->values();
  const std::size_t at = std::max<std::size_t>(column, 1) - 1;
  std::vector<double> values(found->rows);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = all[found->is_row_major ? i * found->columns + at : at * found->rows + i];
  return values;
}

// Throws Error for an array that has a number out of range or is of another length than the first,
// or when there is no row.
RawRecording recording_of_arrays(const ArrayFile& file, const ReadSettings& given) {
  std::string taken;
  ReadSettings settings = with_named_columns(
      given, file.names,
      [&](const auto& what, const auto& remedy) { return file.error("", what, remedy); }, taken);
  for (auto* axes : {&settings.columns.position, &settings.columns.force, &settings.columns.torque})
    if (const auto all = axes->size() == 1 ? file.find(axes->front()) : std::nullopt;
        all && all->columns == 3)
      *axes = {all->name + "(:,1)", all->name + "(:,2)", all->name + "(:,3)"};
  const std::vector<Role> roles = roles_of(settings.columns);
  if (roles.empty())
    throw file.error("", "no " + file.noun + " is named",
                     "Name columns = { time = ..., depth = ..., force = ... } in the manifest. " +
                         file.listed_names());
  std::vector<std::vector<double>> columns;
  std::vector<double> factors;
  for (const Role& role : roles) {
    std::string header;
    columns.push_back(column_of(file, role.name, header));
    factors.push_back(factor_of(
        role, header, settings.units,
        [&](const auto& what, const auto& remedy) { return file.error(role.name, what, remedy); }));
  }
  const std::size_t before = columns[0].size();
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].size() != before)
      throw file.error(
          roles[c].name,
          fmt::format("has {} rows, {} has {}", columns[c].size(), roles[0].name, before),
          "Give columns of one length.");
  std::optional<double> first_tick;  // of clocks that count from a time long past
  for (std::size_t c = 0; c < columns.size(); ++c)
    if ((roles[c].meaning == Meaning::time || roles[c].meaning == Meaning::force_time) &&
        before > 0 && std::isfinite(columns[c][0]) && std::abs(columns[c][0]) > kLargestNumber) {
      first_tick = first_tick.value_or(columns[c][0]);
      for (double& tick : columns[c]) tick -= *first_tick;
    }
  std::vector<std::size_t> line;
  for (std::size_t i = 0; i < before; ++i) {
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (!(std::abs(columns[c][i]) <= kLargestNumber))
        throw file.error(roles[c].name, fmt::format("row {} is not a number in range", i + 1),
                         kBadRowRemedy);
    line.push_back(i + 1);
  }
  if (line.empty()) throw file.error(roles[0].name, "has no row of numbers", kNoRowRemedy);
  RawRecording recording =
      recording_of(roles, std::move(columns), factors, std::move(line), settings);
  if (!taken.empty()) recording.taken.push_back(taken);
  return recording;
}

// A recording of the data sets of an HDF5 file, or of the variables of a MATLAB file, whose rows
// and columns are exchanged.
RawRecording recording_of_hdf5(const h5::Reader& file, const std::filesystem::path& path,
                               bool is_matlab, const ReadSettings& settings) {
  std::vector<std::string> names = file.data_sets();
  if (is_matlab)
    std::erase_if(names, [&](const std::string& name) {
      const std::string type = file.type_of(name);
      return name.find('/') != std::string::npos || !(type.starts_with("float") || type == "int32");
    });
  const auto find = [&](const std::string& name) -> std::optional<NamedArray> {
    const std::string set = name.substr(name.starts_with('/') ? 1 : 0);
    if (is_matlab ? std::ranges::count(names, set) == 0 : !file.has(set)) return std::nullopt;
    const h5::Shape shape = file.shape_of(set);
    const std::size_t columns = std::max<std::size_t>(shape.columns, 1);
    const auto values = [&file, set, shape] { return values_of(file, set, shape); };
    if (is_matlab) return by_columns(set, columns, shape.rows, values);
    return NamedArray{
        set, set + " (" + file.text_if_any(set, "unit") + ")", shape.rows, columns, true, values};
  };
  return recording_of_arrays({path, is_matlab ? "variable" : "data set", names, find}, settings);
}

}  // namespace

bool begins_matlab(std::string_view head) {
  return head.starts_with(kVersion5) || head.starts_with(kVersion73);
}

std::vector<RawRecording> read_matlab(const std::filesystem::path& path, std::string_view bytes,
                                      const ReadSettings& settings) {
  if (bytes.starts_with(kVersion73))
    return {recording_of_hdf5({path, "Save it again."}, path, true, settings)};
  if (!bytes.starts_with(kVersion5))
    throw Error(path.string(), "is no MATLAB file of version 5 to 7.3",
                "Save it with -v7, or leave out `format`.");
  std::deque<std::string> unpacked;
  const auto arrays = variables_5(path, bytes, settings.max_bytes, unpacked);
  std::vector<std::string> names;
  for (const NamedArray& array : arrays) names.push_back(array.name);
  const auto find = [&](const std::string& name) {
    const auto at = std::ranges::find(arrays, name, &NamedArray::name);
    return at == arrays.end() ? std::nullopt : std::optional(*at);
  };
  return {recording_of_arrays({path, "variable", names, find}, settings)};
}

// Data sets of an HDF5 file that the manifest names by path: N values each, or N x 3 for a position
// or force that has one name. A `unit` attribute stands for the brackets of a text header.
bool begins_hdf5(std::string_view head) { return head.starts_with("\x89HDF\r\n\x1a\n"); }

std::vector<RawRecording> read_columns_hdf5(const std::filesystem::path& path, std::string_view,
                                            const ReadSettings& settings) {
  const h5::Reader file(
      path,
      "Name its data sets under `columns` of the manifest, and correct or remove unusable rows.");
  return {recording_of_hdf5(file, path, false, settings)};
}

}  // namespace palpate::importers
