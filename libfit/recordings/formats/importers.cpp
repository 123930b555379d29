#include "libfit/recordings/formats/importers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <functional>
#include <mutex>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/format_keys.hpp"
#include "libfit/recordings/formats/zip_file.hpp"

namespace palpate::importers {
namespace {

constexpr std::array<Importer, 14> kImporters{{
    {"jpk", "JPK force curve or map: .jpk-force, .jpk-force-map, .jpk-qi-data", begins_zip,
     read_jpk},
    {"igor", "Igor binary wave of an Asylum Research microscope: .ibw", begins_igor, read_igor},
    {"nanoscope", "NanoScope force curve of a Bruker microscope: .spm, .000", begins_nanoscope,
     read_nanoscope},
    {"afmformats", "force curve as afmformats exports it: .tab", begins_afmformats,
     read_afmformats},
    {"afmformats-hdf5", "force curves as afmformats exports them: .h5", nullptr,
     read_afmformats_hdf5},
    {"matlab", "variables of a .mat file (5 to 7.3), named in the manifest", begins_matlab,
     read_matlab},
    {"hdf5", "data sets of an HDF5 file, named in the manifest", begins_hdf5, read_columns_hdf5},
    {"tdms", "channels of a LabVIEW file (TDMS), a recording for each group", begins_tdms,
     read_tdms},
    {"chiaro", "nanoindenter of Optics11 (Chiaro, Piuma), text export", begins_chiaro, read_chiaro},
    {"afm-workshop", "AFMWorkshop force-distance curve, extend and retract side by side",
     begins_afm_workshop, read_afm_workshop},
    {"instron", "compression test as the Instron-like export of the silicone phantoms",
     begins_instron, read_instron},
    {"nt-mdt", "NT-MDT curve: three columns, decimal comma, no header", begins_nt_mdt, read_nt_mdt},
    {"robot-palpation",
     "a row per depth: contact point, surface normal, contact force, desired and current position",
     nullptr, read_robot_palpation},
    {"csv", "delimited text with the columns that the manifest or their own names tell",
     begins_named_columns, read_columns_csv},
}};

constexpr std::size_t kHeadBytes = 4096;  // what the formats look at

bool has_columns(const ColumnNames& c) {
  return !c.depth.empty() || !c.position.empty() || !c.force.empty();
}

Error numpy_error(const std::filesystem::path& path, const std::string& what) {
  return Error(path.string(), what + ", which is not read",
               "Save it as text, here of an archive a: numpy.savetxt(\"a.csv\", "
               "numpy.column_stack(list(a.values())), delimiter=\",\", header=\",\".join(a), "
               "comments=\"\").");
}

// Files that are packed as those of JPK are, and hold something else.
void refuse_other_zip(const std::filesystem::path& path, std::string_view bytes,
                      const ReadSettings& settings) {
  const ZipFile zip(path, bytes, settings.max_bytes);
  std::vector<std::string> arrays;
  for (const std::string& name : zip.names()) {
    if (name.ends_with(".npy")) arrays.push_back(name.substr(0, name.size() - 4));
    if (name.starts_with("xl/") || name == "content.xml")
      throw Error(path.string(), "is a spreadsheet, which is not read", "Save the sheet as CSV.");
  }
  if (!arrays.empty())
    throw numpy_error(path, "is an archive of NumPy arrays (" + listed(arrays) + ")");
}

// The format of a file that the manifest leaves open. Columns named in the manifest mean a table.
const Importer& recognise(const std::filesystem::path& path, std::string_view bytes,
                          const ReadSettings& settings) {
  const std::string_view head = bytes.substr(0, kHeadBytes);
  // Of HDF5 files those of afmformats say in every curve how it was imaged.
  if (begins_hdf5(head) && !has_columns(settings.columns) &&
      bytes.find("imaging mode") != std::string_view::npos)
    return *importer_named("afmformats-hdf5");
  const bool is_binary = begins_hdf5(head) || begins_zip(head) || begins_igor(head) ||
                         begins_matlab(head) || begins_nanoscope(head) || begins_tdms(head);
  if (begins_zip(head)) refuse_other_zip(path, bytes, settings);
  if (head.starts_with("\x93NUMPY")) throw numpy_error(path, "is an array of NumPy");
  if (has_columns(settings.columns) && !is_binary) return *importer_named("csv");
  for (const Importer& row : kImporters)
    if (row.begins && row.begins(head)) return row;
  const TextFile check(path, bytes, "latin-1");  // empty and binary files say so themselves
  throw Error(
      path.string() + ":1", "is in no format that is known by its beginning",
      "Name its columns in the manifest: columns = { time = ..., depth = ..., force = ... }, or in "
      "its header with their units: t_s, x_mm, F_N.");
}

bool is_read_by_hdf5(std::string_view bytes) {
  return begins_hdf5(bytes) || bytes.starts_with("MATLAB 7.3");
}

// The library keeps global state: one file at a time, and none is open where the process forks.
std::vector<RawRecording> read_rehearsed(const std::filesystem::path& path,
                                         const std::function<std::vector<RawRecording>()>& read) {
  static std::mutex library;
  const std::lock_guard lock(library);
  rehearse(path, [&] { read(); });
  return read();
}

}  // namespace

std::span<const Importer> importers() { return kImporters; }

const Importer* importer_named(std::string_view name) {
  const auto row = std::find_if(kImporters.begin(), kImporters.end(),
                                [&](const Importer& r) { return r.name == name; });
  return row == kImporters.end() ? nullptr : &*row;
}

std::vector<RawRecording> read_recordings(const std::filesystem::path& path, std::string_view bytes,
                                          const ReadSettings& given) {
  ReadSettings settings = given;
  std::string text;
  if (is_utf16(bytes)) {
    text = utf8_of(path, bytes);
    bytes = text, settings.encoding = "utf-8";
  }
  const Importer* row = settings.format == "auto" ? &recognise(path, bytes, settings)
                                                  : importer_named(settings.format);
  if (!row)
    throw Error(path.string(), "format \"" + settings.format + "\" is not known",
                "Leave it out, or name one that is.");
  for (const SaidKey& said : settings.said)
    if (const FormatKey* key = format_key(said.name); key && !is_read_by(*key, row->name))
      throw Error(said.where,
                  fmt::format("`{}` does nothing for {}, which is read as {}", said.name,
                              path.string(), row->name),
                  std::string(key->remedy));
  const auto recordings_of = [&] { return row->read(path, bytes, settings); };
  auto recordings = is_read_by_hdf5(bytes) ? read_rehearsed(path, recordings_of) : recordings_of();
  for (RawRecording& r : recordings) {
    r.format = row->name;
    if (!r.unread && ((r.travel_m.empty() && r.position_m.rows() == 0) ||
                      (r.push_N.empty() && r.force_N.rows() == 0)))
      throw Error(path.string(), "names neither one axis nor three of position and force",
                  "Name depth or three positions, and one force or three, under `columns`.");
    if (r.probe_radius_m)
      r.taken.push_back("tip radius " + number(1e6 * *r.probe_radius_m) + " um");
    if (r.contact_m) r.taken.push_back("position " + coordinates(*r.contact_m));
  }
  return recordings;
}

}  // namespace palpate::importers
