#pragma once

#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace palpate::testing_support {

/// A file or folder of the data shared beside the checkout, which need not be there.
inline std::filesystem::path shared_data(const std::string& name) {
  return std::filesystem::path(PALPATE_SOURCE_DIR "/../shared") / name;
}

/// Numbers of a comma-separated file below its header.
inline std::vector<std::vector<double>> number_rows(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

/// A file's name as part of a test's name: letters, digits and underscores.
inline std::string file_as_name(std::string file) {
  for (char& c : file)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return file;
}

}  // namespace palpate::testing_support

/// Skips a test in words that tools/test.sh counts: "needs shared data: data/surfaces".
#define PALPATE_NEEDS_DATA(name)                                             \
  if (!std::filesystem::exists(palpate::testing_support::shared_data(name))) \
  GTEST_SKIP() << "needs shared data: " << (name)
