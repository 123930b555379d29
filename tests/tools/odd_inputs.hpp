#pragma once

#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "tests/tools/block_scene.hpp"

namespace palpate::tools {

using namespace testing_support;

enum Status { kRead = 0, kRefused = 1, kNoVerdict = 3 };

struct OddInput {
  const char* what;
  std::string file, content;
  Status status;
  const char* answer;     ///< pattern in the output
  std::string keys = {};  ///< added to a manifest; of a scene, in place of `content`
};

/// The text with `to` wherever `from` was.
inline std::string all_replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// Runs the command of each row in the folder, which then holds the row's file.
template <class Command>
void expect_answers(const Folder& folder, const std::vector<OddInput>& inputs, Command&& command) {
  for (const OddInput& input : inputs) {
    SCOPED_TRACE(input.what);
    folder.write(input.file, input.content);
    const Outcome outcome = palpate(folder, command(input));
    EXPECT_EQ(outcome.status, input.status) << outcome.out << outcome.err;
    EXPECT_TRUE(std::regex_search(outcome.out + outcome.err, std::regex(input.answer)))
        << outcome.out << outcome.err << "is not: " << input.answer;
  }
}

}  // namespace palpate::tools
