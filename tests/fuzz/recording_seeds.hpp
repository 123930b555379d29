#pragma once

// Seeds of binary recordings for fuzz_recordings.cpp, whose first bytes say format and settings.

#include <array>
#include <string>

#include "tests/support/afm_files.hpp"

namespace palpate::fuzz {

/// Format of an input by its first byte, from '0' on. Seeds rely on the order: new ones go last.
/// HDF5's own code is left to fuzz_reader.cpp.
inline constexpr std::array kSeedFormats{
    "jpk",     "igor",   "afmformats",      "csv", "matlab",    "csv", "chiaro", "afm-workshop",
    "instron", "nt-mdt", "robot-palpation", "csv", "nanoscope", "tdms"};

/// The parts of a zip file as a list, so that mutations reach them: name, 1, content, 2, and again.
inline std::string list_of(const testing_support::Parts& parts) {
  std::string list;
  for (const auto& [name, content] : parts) list += name + '\1' + content + "\2\2\2";
  return list;
}

/// The zip file of such a list.
inline std::string zip_of_list(const std::string& list) {
  testing_support::Parts parts;
  for (std::size_t first = 0; first < list.size();) {
    const std::size_t end = std::min(list.find("\2\2\2", first), list.size()),
                      name = list.find('\1', first);
    if (name < end && name > first && name - first < 200)
      parts[list.substr(first, list.substr(first, name - first).find('\0'))] =
          list.substr(name + 1, end - name - 1);
    first = end + 3;
  }
  return testing_support::zip_of(parts);
}

/// Every binary format as it should be, and JPK as the zip file itself.
inline std::map<std::string, std::string> recording_seeds() {
  using namespace testing_support;
  return {
      {"jpk_curve", "0 01" + list_of(jpk_curve())},
      {"jpk_pause", "0 01" + list_of(jpk_curve(true, 50))},
      {"jpk_map", "0 00" + list_of(jpk_map(2))},
      {"jpk_zip", "0 03" + zip_of(jpk_curve())},
      {"nanoscope", "< 03" + nanoscope_curve()},
      {"tdms", "= 01" + tdms_file()},
      {"tdms_rows", "= 01" + tdms_file({.is_interleaved = true, .is_big = true, .segments = 3})},
      {"igor", "1 01" + igor_wave()},
      {"igor_whole", "1 03" + igor_wave()},
      {"afmformats", "2 01" + afmformats_table()},
      {"matlab", "4 01" + matlab_file()}};
}

}  // namespace palpate::fuzz
