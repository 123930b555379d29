#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/placing/place.hpp"
#include "libfit/recordings/placing/registration.hpp"

namespace palpate::recordings {

/// What turns the results of a batch into samples on a body.
struct AssembleOptions {
  const Surface* surface = nullptr;   ///< positions are projected onto it
  std::optional<RigidMotion> motion;  ///< rig to body, where it is known
  bool fits_to_surface = false;       ///< refine it by the contact points
  double place_tolerance_m = 3e-3;    ///< from the surface, and from the named position
  bool pools_repeats = true;          ///< presses of one point at one rate become one experiment
};

/// A recording that made it into the samples, or one that was refused on the way.
struct Outcome {
  std::size_t item = 0;  ///< of the batch
  std::string name;      ///< within its file
  std::string point;
  std::int32_t experiment = -1;  ///< -1: refused
  std::optional<Failure> failure;
  double surface_distance_m = 0;  ///< NaN without a surface
};

struct Assembled {
  Samples samples;
  std::vector<Outcome> outcomes;  ///< every recording and every item that gave none, in order
  std::optional<Registration> registration;
  std::vector<std::string>
      notes;  ///< rates and hysteresis that stand out of the noise, a sentence each

  std::size_t failed() const;
};

/// Places, checks against each other, pools and numbers the recordings of a batch. Refused are
/// recordings too far from the surface or from the position that the manifest names, without a
/// place or normal, and those whose stiffness is implausible, or a prefix away from the others of
/// the batch. results: one per item. Throws Error when a registration is impossible.
Assembled assemble(const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const AssembleOptions& options);

/// Writes what became of every recording, whole or not at all: CSV with a row each
/// (file,line,point,status,grade,reason,remedy,...), and JSON with the same and the totals. The
/// same batch gives the same bytes, however it was interrupted.
void write_summary(const std::filesystem::path& csv, const std::filesystem::path& json,
                   const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const Assembled& assembled);

/// The totals and notes alone, with the refused recordings, as one JSON object for stdout.
std::string summary_json(const std::vector<BatchItem>& items,
                         const std::vector<ItemResult>& results, const Assembled& assembled);

/// Line of a failure's place, "" when it names none.
std::string line_of(const Failure& failure);

/// How an apparent modulus changes with what the manifest says of the cantilever, as powers: 1 %
/// more stiffness makes it `stiffness` % larger.
struct CantileverEffect {
  double stiffness = 0, sensitivity = 0;
  double max_sensitivity_m = 0;  ///< on a rigid body the steepest third would show this one
};

/// Of one recording, from its rows: F = k s V and depth = scanner - s V, so E ~ F / depth^p goes
/// as k s^(1 + p bend / depth); where the file states the force, as k^(-p bend / depth). Nothing
/// without a cantilever or a good row.
std::optional<CantileverEffect> cantilever_effect(const BatchItem& item, const Conditioned& r);

/// A sentence about all imported recordings that use one: what it was taken to be, what 10 % of it
/// does to the moduli (medians), and what the stated deviations leave open. Empty when none does.
std::vector<std::string> cantilever_notes(const std::vector<BatchItem>& items,
                                          const std::vector<Candidate>& candidates);

}  // namespace palpate::recordings
