#pragma once

#include <vector>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {

/// A body in memory of its own.
struct DamagedBody {
  explicit DamagedBody(const Asset& asset) : memory(runtime::body_bytes(asset) / 8) {
    runtime::start_body(asset, memory.data());
    view = runtime::with_body(asset, memory.data());
  }
  std::vector<std::uint64_t> memory;
  runtime::AssetView view;
};

}  // namespace palpate::test
