#pragma once

// Seeds of binary recordings for fuzz_recordings.cpp, whose first bytes say format and settings.

#include <array>
#include <map>
#include <string>

#include "tests/support/matlab_file.hpp"

namespace palpate::fuzz {

/// Format of an input by its first byte, from '0' on. Seeds rely on the order: new ones go last.
/// HDF5's own code is left to fuzz_reader.cpp.
inline constexpr std::array kSeedFormats{"csv", "matlab", "robot-palpation"};

/// The binary format as it should be.
inline std::map<std::string, std::string> recording_seeds() {
  return {{"matlab", "1 01" + testing_support::matlab_file()}};
}

}  // namespace palpate::fuzz
