#pragma once

#include <fmt/format.h>

#include <string>

namespace palpate::fit {

/// A share in words of a report: 0.0213 is "2.1 %".
inline std::string percent(double share) { return fmt::format("{:.1f} %", 100 * share); }

/// Appends a sentence to a point's message.
inline void add_sentence(std::string& message, const std::string& sentence) {
  message += (message.empty() ? "" : "; ") + sentence;
}

}  // namespace palpate::fit
