#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "libfit/core/error.hpp"

namespace palpate::testing_io {

/// A folder of its own for each test, removed afterwards.
class ScratchTest : public testing::Test {
 protected:
  ScratchTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "." + info->name();
    for (char& c : name)
      if (c == '/') c = '_';
    folder_ = std::filesystem::temp_directory_path() /
              ("palpate-io-" + std::to_string(::getpid()) + "-" + name);
    std::filesystem::create_directories(folder_);
  }
  ~ScratchTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::filesystem::path at(const std::string& name) const { return folder_ / name; }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      names.push_back(entry.path().filename().string());
    return names;
  }

  std::filesystem::path folder_;
};

/// Without waiting for the disk, as atomic writes do: for loops over many damaged files.
inline void write_quickly(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// "WHERE: WHAT" of the Error that `call` throws with the folder cut off; "" when it throws none.
template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_FALSE(error.remedy().empty());
    const std::string where = error.where();
    return where.substr(where.rfind("palpate-io-") == std::string::npos
                            ? 0
                            : where.find('/', where.rfind("palpate-io-")) + 1) +
           ": " + error.fact();
  }
  return "";
}

/// Bit for bit, so that NaN equals itself and -0 differs from 0.
template <class A, class B>
bool same_bits(const A& a, const B& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.size() == 0 ||
          std::memcmp(a.data(), b.data(), sizeof(*a.data()) * static_cast<std::size_t>(a.size())) ==
              0);
}

}  // namespace palpate::testing_io
