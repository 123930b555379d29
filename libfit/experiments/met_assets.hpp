#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "libfit/core/probe.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// An asset as indenters meet it (docs/method.md, section 30), each tabulated once.
class MetAssets {
 public:
  explicit MetAssets(const runtime::AssetView& asset) : asset_(asset) {}
  MetAssets(const MetAssets&) = delete;
  MetAssets& operator=(const MetAssets&) = delete;

  /// Null: as it is, for its own ball, and where it does not say which ball that was.
  const runtime::AssetView* of(const Indenter& end);
  /// The same for the balls of a tool.
  void put_into(const std::vector<Indenter>& end, runtime::ToolShape& shape);

 private:
  struct Met {
    std::uint64_t mark;
    std::vector<std::uint64_t> memory;
    runtime::AssetView view;
  };
  const runtime::AssetView& asset_;
  std::deque<Met> met_;
};

}  // namespace palpate
