#include "libfit/recordings/formats/importers.hpp"

#include <algorithm>
#include <array>

namespace palpate::importers {
namespace {

constexpr std::array<Importer, 7> kImporters{{
    {"hdf5", "data sets of an HDF5 file, named in the manifest", begins_hdf5, read_columns_hdf5},
    {"chiaro", "Optics11 Chiaro nanoindenter, text export", begins_chiaro, read_chiaro},
    {"afm-workshop", "AFMWorkshop force-distance curve, extend and retract side by side",
     begins_afm_workshop, read_afm_workshop},
    {"instron", "compression test as the Instron-like export of the silicone phantoms",
     begins_instron, read_instron},
    {"nt-mdt", "NT-MDT curve: three columns, decimal comma, no header", begins_nt_mdt, read_nt_mdt},
    {"robot-palpation",
     "a row per depth: contact point, surface normal, contact force, desired and current position",
     nullptr, read_robot_palpation},
    {"csv", "delimited text with the columns that the manifest names", nullptr, read_columns_csv},
}};

constexpr std::size_t kHeadBytes = 4096;  // what the formats look at

bool has_columns(const ColumnNames& c) {
  return !c.depth.empty() || !c.position.empty() || !c.force.empty();
}

// The format of a file that the manifest leaves open. Columns named in the manifest mean a table.
const Importer& recognise(const std::filesystem::path& path, std::string_view bytes,
                          const ReadSettings& settings) {
  const std::string_view head = bytes.substr(0, kHeadBytes);
  if (begins_hdf5(head)) return *importer_named("hdf5");
  if (has_columns(settings.columns)) return *importer_named("csv");
  for (const Importer& row : kImporters)
    if (row.begins && row.begins(head)) return row;
  const TextFile check(path, bytes, "latin-1");  // empty and binary files say so themselves
  throw Error(
      path.string() + ":1", "is in no format that is known by its beginning",
      "Name its columns in the manifest: columns = { time = ..., depth = ..., force = ... }.");
}

}  // namespace

std::span<const Importer> importers() { return kImporters; }

const Importer* importer_named(std::string_view name) {
  const auto row = std::find_if(kImporters.begin(), kImporters.end(),
                                [&](const Importer& r) { return r.name == name; });
  return row == kImporters.end() ? nullptr : &*row;
}

std::vector<RawRecording> read_recordings(const std::filesystem::path& path, std::string_view bytes,
                                          const ReadSettings& settings) {
  if (settings.format == "auto")
    return recognise(path, bytes, settings).read(path, bytes, settings);
  const Importer* row = importer_named(settings.format);
  if (!row)
    throw Error(path.string(), "format \"" + settings.format + "\" is not known",
                "Leave it out, or name one that is.");
  return row->read(path, bytes, settings);
}

}  // namespace palpate::importers
