#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "libfem/mesh/surface/surface.hpp"
#include "libfit/core/body.hpp"
#include "libfit/runtime/asset/view.hpp"
#include "tools/manifest/manifest.hpp"

namespace palpate::scan {
struct ScanFit;
}

namespace palpate::tools {

/// Input of `palpate import`. output: samples.h5; its tables lie beside it. Empty: nothing
/// is written, and every file is read.
struct ImportRequest {
  Manifest manifest;
  std::filesystem::path output;
  int jobs = 0;  ///< threads, 0 for all cores
  /// Hold points out of the fit also where the manifest says nothing (held_out_points).
  bool holds_out = false;
  /// A recording that is compared with an asset: scans are placed on its surface and corrected by
  /// the numbers of the rig that made `earlier` (samples.h5; empty: none); null: they make a body.
  const runtime::AssetView* asset = nullptr;
  std::filesystem::path earlier = {};
};

/// Recordings of a manifest, read, conditioned and placed on the body; results: one per item.
struct ReadRecordings {
  std::vector<recordings::ItemResult> results;
  recordings::Assembled assembled;
  std::vector<char> is_held_out;              ///< of the assembled samples' points, from the fit
  std::shared_ptr<const scan::ScanFit> scan;  ///< of the passes that are not held out
  recordings::RigidMotion motion;             ///< of a scan onto the mesh of its body
};

/// Throws Error where no recording that a manifest names is there. Single ones are refused when
/// they are read.
void check_recordings_exist(const Manifest& manifest);

/// Says on stderr what was found. Throws Error on a bad surface, Interrupted when the
/// user stopped it.
ReadRecordings read_recordings(const ImportRequest& request);

/// Writes them: samples.h5, without points that are held out, and what lies beside it
/// (docs/formats/manifest.md). Returns totals, notes and refusals. Throws Error when nothing could
/// be imported.
nlohmann::ordered_json write_recordings(const ImportRequest& request, const ReadRecordings& read,
                                        const std::string& fingerprint);
/// Files beside samples.h5 in which an import of scans keeps the surface and the curves that it
/// found together, samples.scan_body.h5 and samples.scan_curves.h5; none of other recordings.
std::filesystem::path scan_body_path(std::filesystem::path samples);
std::filesystem::path scan_curves_path(std::filesystem::path samples);
/// Numbers of scan::Recording in the latter, and of the motion onto the mesh (rotation by columns,
/// translation in m), blanks between them.
inline constexpr const char* kRecordingAttribute = "recording";
/// Totals and every recording, of an import to samples.h5.
std::filesystem::path import_summary_path(const std::filesystem::path& samples);

/// Of the manifest's `surface`, mended as `prepare` does; nothing where it names none.
std::optional<Surface> surface_of(const Manifest& manifest);

/// The surface that the points of recordings lie on; how far contacts left out lie off it is said
/// on stderr. Throws Error where the contacts make none.
ContactSurface surface_of_contacts(const Samples& samples);

/// OBJ in mm, with the unit in its first line.
std::string obj_text(const Surface& surface);

/// The body of recordings: the manifest's surface, else the one of their contacts, with curves
/// wanted wherever a point answers; test points are the samples'. No volume.
Body body_of_recordings(const Manifest& manifest, const Samples& samples);

}  // namespace palpate::tools
