// Variables of a MATLAB file that the manifest names: "force", or "M(:,2)" for a column of a
// matrix. Version 5 to 7 is read here (variables packed or not, without structures and cells);
// version 7.3 is HDF5, with rows and columns exchanged. Debian's libmatio returns numbers of files
// that are cut short or damaged, without an error. Source: MATLAB MAT-File Format, 2019.

#include <fmt/core.h>

#include <algorithm>
#include <bit>
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

// A matrix of numbers, column by column; rows and columns 0: an array of another kind.
struct Variable {
  std::string name;
  std::size_t rows = 0, columns = 0;
  std::function<double(std::size_t)> value;
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
Variable variable_of(MatElements parts) {
  const auto flags = parts.next(), sizes = parts.next(), name = parts.next();
  if (flags.data.size() < 4 || sizes.data.size() % 4 != 0) throw parts.damaged();
  const auto word =
      static_cast<std::uint32_t>(number_at<std::uint32_t>(flags.data.data(), parts.is_swapped()));
  const int array_class = static_cast<int>(word & 0xff);  // 6 to 15 are of numbers
  Variable variable;
  variable.name = std::string(name.data);
  const bool is_complex = (word >> 8) & 8;
  if (array_class < 6 || array_class > 15 || is_complex || sizes.data.size() != 8) return variable;
  const auto numbers = parts.next();
  const auto* storage = std::ranges::find(kStorages, numbers.kind, &Storage::kind);
  const auto size = [&](std::size_t k) {
    return std::size_t(number_at<std::uint32_t>(sizes.data.data() + 4 * k, parts.is_swapped()));
  };
  if (storage == std::end(kStorages) || size(0) > numbers.data.size() ||
      size(1) > numbers.data.size() || size(0) * size(1) != numbers.data.size() / storage->bytes)
    throw parts.damaged();
  variable.rows = size(0), variable.columns = size(1);
  variable.value = [data = numbers.data, of = *storage, swap = parts.is_swapped()](std::size_t i) {
    return of.read(data.data() + i * of.bytes, swap);
  };
  return variable;
}

// All variables of a file of version 5; `unpacked` keeps what they point to.
std::vector<Variable> variables_5(const std::filesystem::path& path, std::string_view bytes,
                                  std::uintmax_t max_bytes, std::deque<std::string>& unpacked) {
  if (bytes.size() < 128) throw Error(path.string(), kDamaged, "Save it again.");
  const bool is_little = bytes.substr(126, 2) == "IM";
  const bool is_swapped = is_little != (std::endian::native == std::endian::little);
  std::vector<Variable> variables;
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

// Those of version 7.3 that hold real numbers.
std::vector<Variable> variables_73(const h5::Reader& file) {
  std::vector<Variable> variables;
  for (const std::string& name : file.data_sets()) {
    const std::string type = file.type_of(name);
    if (name.find('/') != std::string::npos || !(type.starts_with("float") || type == "int32"))
      continue;
    const h5::Shape shape = file.shape_of(name);
    variables.push_back(
        {name, std::max<std::size_t>(shape.columns, 1), shape.rows,
         [numbers = values_of(file, name, shape)](std::size_t i) { return numbers[i]; }});
  }
  return variables;
}

// "M(:,2)": {"M", 2}; "t": {"t", 0}.
std::pair<std::string, std::size_t> variable_and_column(const std::string& name) {
  const std::size_t open = name.find("(:,");
  if (open == std::string::npos || !name.ends_with(')')) return {name, 0};
  const auto column = parse_number(name.substr(open + 3, name.size() - open - 4), '.');
  if (!column || !(*column >= 1) || *column > 1e6) return {name, 0};
  return {name.substr(0, open), static_cast<std::size_t>(*column)};
}

std::vector<double> column_of(const std::vector<Variable>& variables, const std::string& name,
                              const FailColumn& fail) {
  const auto [of, column] = variable_and_column(name);
  const auto found = std::ranges::find(variables, of, &Variable::name);
  std::vector<std::string> names;
  for (const Variable& v : variables)
    if (v.value) names.push_back(v.name);
  if (found == variables.end())
    throw fail("variable is missing", "There are: " + listed(names).substr(0, 300) + ".");
  if (!found->value || found->rows * found->columns == 0)
    throw fail("is no array of real numbers", "There are: " + listed(names).substr(0, 300) + ".");
  const bool is_vector = found->rows == 1 || found->columns == 1;
  if (column == 0 && !is_vector)
    throw fail(fmt::format("is a matrix of {} columns", found->columns),
               "Name one of them: \"" + of + "(:,1)\".");
  if (column > found->columns)
    throw fail(fmt::format("has {} columns", found->columns), "Name one that is there.");
  const std::size_t rows = column == 0 ? found->rows * found->columns : found->rows,
                    first = column == 0 ? 0 : (column - 1) * found->rows;
  std::vector<double> values(rows);
  for (std::size_t i = 0; i < rows; ++i) values[i] = found->value(first + i);
  return values;
}

RawRecording recording_of(const std::filesystem::path& path, const std::vector<Variable>& variables,
                          const ReadSettings& settings) {
  const auto fail = [&](const std::string& name, const std::string& what,
                        const std::string& remedy) {
    return Error(path.string() + (name.empty() ? "" : ":" + name), what, remedy);
  };
  std::vector<std::string> names;
  for (const Variable& variable : variables) names.push_back(variable.name);
  return recording_of_arrays(
      {.names = names,
       .fail = fail,
       .unnamed = fail(
           "", "no variable is named",
           "Name columns = { time = ..., depth = ..., force = ... } in the manifest. There are: " +
               listed(names).substr(0, 300) + "."),
       .axes =
           [&](const std::string& name) {
             const bool has_three = std::ranges::any_of(variables, [&](const Variable& v) {
               return v.name == name && v.columns == 3 && v.rows > 1;
             });
             return has_three ? std::vector{name + "(:,1)", name + "(:,2)", name + "(:,3)"}
                              : std::vector{name};
           },
       .header = [](const std::string& name) { return variable_and_column(name).first; },
       .column =
           [&](const std::string& name) {
             return column_of(variables, name, [&](const auto& what, const auto& remedy) {
               return fail(name, what, remedy);
             });
           }},
      settings);
}

std::pair<std::string, std::size_t> set_and_axis(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  if (colon == std::string::npos || colon + 2 != name.size()) return {name, 0};
  return {name.substr(0, colon), static_cast<std::size_t>(name.back() - '0')};
}

std::vector<double> column_of(const h5::Reader& file, const std::string& name) {
  const auto [set, axis] = set_and_axis(name);
  const h5::Shape shape = file.shape_of(set);
  const auto values = values_of(file, set, shape);
  const std::size_t stride = shape.columns == 0 ? 1 : shape.columns;
  if (axis >= stride) throw file.error(set, fmt::format("has no column {}", axis));
  std::vector<double> column;
  for (std::size_t i = axis; i < values.size(); i += stride) column.push_back(values[i]);
  return column;
}

void strip_root(ColumnNames& names) {
  const auto strip = [](std::string& name) {
    if (name.starts_with('/')) name.erase(0, 1);
  };
  for (std::string* name :
       {&names.time, &names.depth, &names.force_time, &names.retract_depth, &names.retract_force})
    strip(*name);
  for (auto* axes : {&names.position, &names.force, &names.contact, &names.normal, &names.torque})
    for (std::string& name : *axes) strip(name);
}

}  // namespace

bool begins_matlab(std::string_view head) {
  return head.starts_with(kVersion5) || head.starts_with(kVersion73);
}

std::vector<RawRecording> read_matlab(const std::filesystem::path& path, std::string_view bytes,
                                      const ReadSettings& settings) {
  if (bytes.starts_with(kVersion73)) {
    const h5::Reader file(path, "Save it again.");
    return {recording_of(path, variables_73(file), settings)};
  }
  if (!bytes.starts_with(kVersion5))
    throw Error(path.string(), "is no MATLAB file of version 5 to 7.3",
                "Save it with -v7, or leave out `format`.");
  std::deque<std::string> unpacked;
  return {recording_of(path, variables_5(path, bytes, settings.max_bytes, unpacked), settings)};
}

// Data sets of an HDF5 file that the manifest names by path: N values each, or N x 3 for a position
// or force that has one name. A `unit` attribute stands for the brackets of a text header.
bool begins_hdf5(std::string_view head) { return head.starts_with("\x89HDF\r\n\x1a\n"); }

std::vector<RawRecording> read_columns_hdf5(const std::filesystem::path& path, std::string_view,
                                            const ReadSettings& given) {
  const h5::Reader file(
      path,
      "Name its data sets under `columns` of the manifest, and correct or remove unusable rows "
      "(or import with --drop-invalid).");
  const auto fail = [&](const std::string& name, const std::string& what,
                        const std::string& remedy) {
    return Error(path.string() + (name.empty() ? "" : ":" + set_and_axis(name).first), what,
                 remedy);
  };
  ReadSettings settings = given;
  strip_root(settings.columns);
  return {recording_of_arrays(
      {.names = file.data_sets(),
       .fail = fail,
       .unnamed = file.error("", "no data set is named"),
       .axes =
           [&](const std::string& set) {
             return file.has(set) && file.shape_of(set).columns == 3
                        ? std::vector{set + ":0", set + ":1", set + ":2"}
                        : std::vector{set};
           },
       .header =
           [&](const std::string& name) {
             const std::string set = set_and_axis(name).first;
             return set + " (" + file.text_if_any(set, "unit") + ")";
           },
       .column =
           [&](const std::string& name) {
             if (!file.has(set_and_axis(name).first))
               throw fail(name, "data set is missing",
                          "There are: " + listed(file.data_sets()).substr(0, 300) + ".");
             return column_of(file, name);
           }},
      settings)};
}

}  // namespace palpate::importers
