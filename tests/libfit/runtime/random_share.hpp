#pragma once

#include <cstdint>

namespace palpate::test {

/// Shares in [0, 1), the same on every machine.
struct Random {
  std::uint64_t state;
  double share() {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return double(state >> 11) / 9007199254740992.0;
  }
};

}  // namespace palpate::test
