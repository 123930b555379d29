#pragma once

#include "libfit/recordings/formats/recording.hpp"
#include "libfit/recordings/formats/text_file.hpp"

namespace palpate::importers {

/// Force and tip travel of an atomic force microscope: the cantilever bends by the signal times its
/// sensitivity, and the tip goes where the scanner goes, less that.
/// scanner_m, signal: of the way in, then of the way back from row `retract_begins`. Throws Error
/// at the header line when `settings.cantilever` is missing or not positive.
inline void bend_cantilever(const TextFile& file, std::size_t header, const ReadSettings& settings,
                            const std::vector<double>& scanner_m, const std::vector<double>& signal,
                            RawRecording& out) {
  if (!settings.cantilever || !(settings.cantilever->stiffness_N_m > 0) ||
      !(settings.cantilever->sensitivity_m > 0))
    throw file.error(header, "the force is a raw cantilever signal",
                     "Say cantilever = { stiffness = 0.1, sensitivity = \"60 nm\" } in the "
                     "manifest: N/m, and deflection per unit of the signal.");
  out.is_force_from_signal = true;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const double bent_m = (signal[i] - signal.front()) * settings.cantilever->sensitivity_m;
    out.push_N.push_back(bent_m * settings.cantilever->stiffness_N_m);
    out.travel_m.push_back(scanner_m[i] - bent_m);
  }
}

}  // namespace palpate::importers
