#pragma once

#include <functional>
#include <vector>

#include "libfit/recordings/formats/recording.hpp"

// What the files of atomic force microscopes have in common: a cantilever that bends, a scanner
// that moves it, a place seen from above.

namespace palpate::importers {

/// Makes the error of what and remedy.
using FailCantilever = std::function<Error(const std::string&, const std::string&)>;

/// The cantilever of a signal: what the manifest says, and where it says nothing what the file
/// does. Notes in `out` what was taken from the file. Throws what `fail` makes of what and remedy
/// when either is in neither, or is no positive number; a deflection in metres needs no
/// sensitivity.
Cantilever cantilever_of(const ReadSettings& settings, const Cantilever& stated,
                         const FailCantilever& fail, RawRecording& out,
                         bool is_bent_in_metres = false);

/// Deflection from its first value on, of a raw signal. signal: not empty.
std::vector<double> bent_by(const Cantilever& cantilever, const std::vector<double>& signal);

/// Force and tip travel: the tip goes where the scanner goes, less what the cantilever bends.
/// scanner_m: inward; bent_m: away from the body; both #N. Appends to `out`.
void bend_cantilever(const Cantilever& cantilever, const std::vector<double>& scanner_m,
                     const std::vector<double>& bent_m, RawRecording& out);

/// Place of a curve in the plane of the scanner, and the way in: down.
void place_in_plane(double x_m, double y_m, RawRecording& out);

/// The recordings of a file of several, each by its name: what cannot be read says so and leaves
/// the others. Throws Error when that is all of them, or what is wrong with the file as a whole.
std::vector<RawRecording> read_each(const std::filesystem::path& path,
                                    const std::vector<std::string>& names,
                                    const std::function<RawRecording(const std::string&)>& read);

/// Throws what `fail` makes unless all numbers of the recording are finite and within 1e15 of zero.
void check_numbers(const RawRecording& recording, const FailCantilever& fail);

}  // namespace palpate::importers
