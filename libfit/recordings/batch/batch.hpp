#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/progress.hpp"
#include "libfit/recordings/batch/condition.hpp"

namespace palpate::recordings {

/// Carries points of the rig's frame into the body's: rotation * x + translation_m.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();

  Vec3 operator()(const Vec3& x) const { return rotation * x + translation_m; }
};

/// A motion with what it leaves: distances after it, root mean square and largest.
struct Registration {
  RigidMotion motion;
  double rms_m = 0, largest_m = 0;
  int iterations = 0;  ///< of ICP; 0 for landmarks alone
};

/// The motion that brings `from` nearest to `to` in the least squares sense, without mirroring.
/// Throws Error when there are fewer than 3 pairs or they lie on one line.
/// Source: Kabsch (1976), Umeyama (1991).
Registration register_landmarks(const Points& from, const Points& to);

/// Refines a motion so that `points` come to lie on the surface: iterative closest points with
/// distances along the surface's normals (Chen and Medioni 1992), up to 50 steps or until it moves
/// by less than 1e-9 of the surface. Points that lie farther than 3 robust deviations are left out
/// of a step. Throws Error with fewer than 6 points.
Registration register_to_surface(const Points& points, const Surface& surface,
                                 const RigidMotion& start);

/// Where a point belongs on a surface.
struct SurfacePlace {
  Vec3 position_m;
  Vec3 inward;  ///< unit, from the vertex normals
  double distance_m = 0;
};

/// Nearest surface points. Nothing where there is no triangle with an area.
std::vector<std::optional<SurfacePlace>> project(const Points& points, const Surface& surface);

/// One file of a manifest with all that is said about it.
struct BatchItem {
  std::filesystem::path file;
  std::string shown;               ///< the file as the manifest names it
  std::string place;               ///< "manifest.toml:12:1", for errors about the entry itself
  std::string point;               ///< name of the test point; empty: the file's own name
  std::optional<Vec3> position_m;  ///< of the point, in the body's frame
  std::optional<Vec3> normal;      ///< inward unit, in the body's frame
  importers::ReadSettings read;
  SignalSettings signal;
};

/// Name of the point that a recording of a file is of, by its name there: recordings of one point
/// are repeats.
std::string point_of(const BatchItem& item, const std::string& recording);

/// A recording without result.
struct Refused {
  std::string name;  ///< within its file; empty of a whole file
  Error failure;
  SignalTrace trace;  ///< as far as it is known
};

/// The recordings of an item, and those that were refused.
struct ItemResult {
  std::string hash;  ///< ContentHash of the file's bytes; empty when they could not be read
  std::vector<Conditioned> recordings;
  std::vector<Refused> refused;
  bool is_done = false;  ///< else the batch was stopped before
};

/// Uses of the relaxation that recordings show.
enum class RelaxationUse { none, where_sure, always };

/// How a batch is read and becomes samples on a body.
struct BatchOptions {
  int jobs = 0;                            ///< threads, 0: all. Results do not depend on it
  const Surface* surface = nullptr;        ///< of the body, onto which positions are projected
  std::optional<RigidMotion> motion = {};  ///< rig to body, where it is known
  bool fits_to_surface = false;            ///< refine it by the contact points
  double place_tolerance_m = 3e-3;         ///< from the surface, and from the named position
  /// Recordings with holds or several rates show how the body relaxes: rows in time follow from it
  /// never, where it is sure, or where it is doubted, too.
  RelaxationUse relaxation = RelaxationUse::where_sure;
};

/// Reads and conditions every item, in parallel; a bad one becomes a failure and stops nothing.
/// Recordings whose contact the surface says better than they do are conditioned a second time,
/// with it. Returns a result per item, in their order. Stops early, with items not done, when
/// Progress says so.
std::vector<ItemResult> run_batch(const std::vector<BatchItem>& items, const BatchOptions& options,
                                  const Progress& progress);

/// A unit that would bring an implausible modulus to where it belongs.
struct LikelyUnit {
  std::string key;   ///< "units.force", "units.position"
  std::string unit;  ///< what the manifest should probably say
};

/// The unit of force or length that brings `found_Pa` nearest to `expected_Pa`, of those that bring
/// it within a factor of 30; nothing when none does. factor steps are those of SI prefixes. given:
/// the manifest's units, "N" and "mm" where empty.
std::optional<LikelyUnit> likely_unit(double found_Pa, double expected_Pa,
                                      const std::string& force_unit, const std::string& length_unit,
                                      bool has_radius);

/// Why recordings are refused whose apparent modulus no body has (outside their `plausible`), or is
/// a prefix away from that of the others that were made like them. By item and recording of
/// `results`; nothing where a recording is plausible.
std::vector<std::vector<std::optional<Error>>> question_stiffness(
    const std::vector<BatchItem>& items, const std::vector<ItemResult>& results);

/// A sentence on every item whose file holds the bytes of an earlier one and is read as that is:
/// repeats that are none make errors too small, and points that were never pressed.
std::vector<std::string> copy_notes(const std::vector<BatchItem>& items,
                                    const std::vector<ItemResult>& results);

}  // namespace palpate::recordings
