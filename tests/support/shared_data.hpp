#pragma once

#include <cctype>
#include <filesystem>
#include <string>

namespace palpate::testing_support {

/// A file or folder of the data shared beside the checkout, which need not be there.
inline std::filesystem::path shared_data(const std::string& name) {
  return std::filesystem::path(PALPATE_SOURCE_DIR "/../shared") / name;
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
