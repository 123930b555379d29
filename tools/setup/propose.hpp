#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// Decisions of the user; empty: proposed from the mesh.
struct SceneChoices {
  std::string unit{};    ///< "mm", or a length such as "110 mm"
  std::string tissue{};  ///< of data/materials.toml; empty: by the mesh's name, else liver
  bool wrap = false;     ///< whether a wrap may move the surface by more than kMostMoved
  std::string held{};    ///< side that is fixed: -x, +x, -y, +y, -z or +z
  /// What the scene calls the surface where it had to be divided.
  std::filesystem::path divided_mesh = "divided.off";
  bool is_volume = false;              ///< the mesh is one of tetrahedra; it is not divided
  std::vector<MeshGroup> groups = {};  ///< that such a mesh marks
};

/// A scene to start from, and what was noticed, a sentence each.
struct ProposedScene {
  std::string text, unit, tissue;
  std::vector<std::string> notes, warnings;
  /// As the scene has it [m]. is_divided: it is another than the file's, to be written beside it.
  Surface surface;
  bool is_divided = false;
};

/// A commented scene for a surface mesh.
/// mesh: its file, as the scene shall name it. surface: as the file holds it, or the boundary of
/// its tetrahedra, in the file's unit. Faces whose group's name says that they are held are; other
/// groups become inclusions to fill in.
/// The body rests on a flat side whose opposite can be pressed on (held where a quarter of its
/// surface lies); the window lies opposite. A window of few vertices is divided. The ball is as
/// ball_for says; it presses one radius deep, and drags go 0.8 of that, so that they slip.
/// Throws Error on a unit, tissue or side that does not exist, on a mesh beyond mending, and where
/// no window can be pressed.
ProposedScene propose_scene(const std::filesystem::path& mesh, const Surface& surface,
                            const SceneChoices& choices);

/// A manifest to start from.
struct ProposedManifest {
  std::string text;                   ///< manifest.toml, commented
  std::vector<std::string> notes;     ///< what was found, a sentence each
  std::vector<std::string> warnings;  ///< files that nothing could be made of, and guesses
  std::vector<std::string> unread;    ///< of those files, name and reason alone
  std::size_t files = 0;              ///< that it reads
};

/// Looks at every file of a folder and of those in it and proposes how they are read: format, by
/// their first bytes; else columns and units by the names in their headers, and whose force it is,
/// the side to which normals point and whether it was a press or a drag by what makes recordings of
/// the first file of each kind that makes any. Keys that all entries have are in [defaults]. Units
/// that no header says are guessed from the numbers, and said. Where a mesh lies in the folder and
/// tools touched one distance off it, positions are proposed as those of a ball's centre with that
/// radius. manifest: where it is going to be; names of files start at its folder. Throws Error
/// where the folder cannot be read or holds no recording.
ProposedManifest propose_manifest(const std::filesystem::path& folder,
                                  const std::filesystem::path& manifest);

/// A path of the tip to replay on an asset, and what it does.
struct ProposedPath {
  PosePath tip;                 ///< 1 kHz, in the asset's own coordinates, upright there
  Vec3 touched = Vec3::Zero();  ///< where it comes down on the surface [m]
  double depth_m = 0;           ///< below the surface, along the path on which it comes down
  double slide_m = 0;           ///< across
};

/// A path that comes down where the window has its middle, presses to 0.6 of the depth that
/// curves were fitted to, slides as a held-out path does (draw_sliding), and lifts. Every leg
/// begins and ends at rest. Deterministic. Throws Error where no triangle of the asset has measured
/// corners alone.
ProposedPath propose_path(const runtime::AssetView& asset);

/// A side of a body's bounding box that it could rest on, and the window opposite that a tool
/// presses.
struct Window {
  int axis = 2;       ///< of the held side
  double sign = -1;   ///< of its outward direction
  double held_m = 0;  ///< what lies beyond this coordinate is held
  Vec3 centre = Vec3::Zero();
  double radius_m = 0;

  std::string side() const;
  Vec3 outward() const { return sign * Vec3::Unit(axis); }
};

/// The windows of a closed outward surface, the likeliest first: a side that is flat where it rests
/// (a quarter of the surface is held), and opposite to it much that looks away from it. held: the
/// only side to take; empty: all six.
std::vector<Window> windows_of(const Surface& surface, std::string_view held);

/// Per vertex: in the window's sphere, not held, and on the side that looks away from what is held.
std::vector<char> vertices_in(const Window& window, const Surface& surface);

/// Thickness of the body under the window [m], lumens filled: median over its area, along the
/// inward normals; 0 where it has no triangle there.
double thickness_under_m(const Window& window, const Surface& with_lumens);

/// A ball that the window can be pressed with, one radius deep.
struct ProposedBall {
  double radius_m = 0;
  double force_N = 0;  ///< where a press ends, on a half-space (Hertz)
  int reachable = 0;   ///< vertices of the window that it can touch
};

/// Of an eighth of the thickness, 10 mm at most; larger, up to a quarter of it, where half of the
/// rows would be below what a hand feels; and smaller until it reaches most of the window. Nothing
/// where no ball reaches twelve vertices, which test points need, and under a sheet of a 300th of
/// the body's extent. young_Pa, poisson: of the material at rest.
std::optional<ProposedBall> ball_for(const Window& window, const Surface& surface, double young_Pa,
                                     double poisson);

/// Two digits, so that a reader sees a choice and no measurement.
double rounded_m(double length_m);

/// A reading of a file, and the words of the manifest for it.
struct FileReading {
  importers::ReadSettings read;
  ExperimentKind kind = ExperimentKind::press;
  std::vector<std::string> lines;    ///< of the manifest
  std::vector<std::string> guesses;  ///< what no header says, a phrase each
};

/// The first line that is no comment, split; empty of files that are no text.
std::vector<std::string> header_of(const std::filesystem::path& path, const std::string& bytes);

/// Readings of a file that may be meant, the likeliest first: by its first bytes; columns by
/// their names; units, where no header says them; whose force it is; the side to which normals
/// point.
std::vector<FileReading> readings_of(const std::filesystem::path& path, const std::string& bytes);

struct TriedReading {
  FileReading reading;
  recordings::ItemResult result;
};

/// The reading that makes most recordings of a file; of equals the first.
TriedReading best_reading(const std::filesystem::path& path, std::vector<FileReading> readings);

}  // namespace palpate::tools
