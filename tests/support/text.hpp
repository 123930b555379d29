#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

// What tests claim of texts.
namespace palpate::testing_support {

/// Whether a text has the part in it; both are shown where a claim about that is wrong.
inline testing::AssertionResult holds(const std::string& text, const std::string& part) {
  const bool is_there = text.find(part) != std::string::npos;
  return (is_there ? testing::AssertionSuccess() : testing::AssertionFailure())
         << "\"" << part << "\" in\n"
         << text;
}

/// The text with another part in the place of the first `from`, which has to be there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no \"" + from + "\" in\n" + text);
  return text.replace(at, from.size(), to);
}

}  // namespace palpate::testing_support
