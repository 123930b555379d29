#pragma once

#include <filesystem>
#include <vector>

#include "libfit/core/recorded_signals.hpp"
#include "libfit/io/files/files.hpp"

namespace palpate {

inline constexpr FileSchema kSignalsSchema{"palpate-signals",
                                           "Make it again with `palpate import`."};

/// Where the signals of the recordings behind samples are kept: samples.h5, samples.signals.h5.
std::filesystem::path signals_path(std::filesystem::path samples_path);

/// Recordings as they came, for pictures (docs/formats/samples.md). Throws Error on a malformed
/// file.
std::vector<RecordedSignal> read_signals(const std::filesystem::path& path);

/// Stores them, whole or not at all. Refuses what read_signals would refuse.
void write_signals(const std::filesystem::path& path, const std::vector<RecordedSignal>& signals,
                   const Attributes& attributes = {});

}  // namespace palpate
