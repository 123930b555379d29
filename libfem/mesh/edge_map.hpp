#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace palpate::fem {

/// From an edge {a, b} in either order to an index >= 0.
/// Open addressing in flat arrays: a few nanoseconds a look-up, no allocation per edge.
class EdgeMap {
 public:
  explicit EdgeMap(std::size_t expected = 64) {
    std::size_t slots = 64;
    while (slots < 2 * expected) slots *= 2;
    slots_.resize(slots);
  }

  /// Index of the edge, or -1.
  std::int32_t find(std::int32_t a, std::int32_t b) const {
    return slots_[slot_of(key_of(a, b))].value;
  }

  /// Index of the edge, and whether it is new; a new edge gets `value`.
  std::pair<std::int32_t, bool> insert(std::int32_t a, std::int32_t b, std::int32_t value) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    const std::uint64_t key = key_of(a, b);
    Slot& slot = slots_[slot_of(key)];
    if (slot.value >= 0) return {slot.value, false};
    slot = {key, value};
    ++size_;
    return {value, true};
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::int32_t value = -1;
  };

  static std::uint64_t key_of(std::int32_t a, std::int32_t b) {
    const auto [low, high] = std::minmax(a, b);
    return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
  }

  // Finalizer of splitmix64 (Steele, Lea and Flood 2014): neighbouring keys scatter.
  std::size_t slot_of(std::uint64_t key) const {
    std::uint64_t h = key;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    std::size_t slot = (h ^ (h >> 31)) & (slots_.size() - 1);
    while (slots_[slot].value >= 0 && slots_[slot].key != key)
      slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }

  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.value >= 0) slots_[slot_of(slot.key)] = slot;
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

}  // namespace palpate::fem
