#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

/// A key that a reader asked a table for, as the file would say it. What is not known is empty.
struct KeyRead {
  std::string table, key, value, fallback;
};
/// In the order in which they were first asked for, each key of a table once.
using KeyLog = std::vector<KeyRead>;

}  // namespace palpate::tools
