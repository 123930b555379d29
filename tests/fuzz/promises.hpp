#pragma once

// What must hold whatever bytes come; a broken promise aborts, which a fuzzer reports.

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace palpate::fuzz {

inline void promise(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

inline void promise_finite(const double* numbers, int count, const char* what) {
  for (int i = 0; i < count; ++i) promise(std::isfinite(numbers[i]), what);
}

/// 64-byte aligned copy of an input, as a file map would be, in a block of exactly its size:
/// reading past its end is an error that the address sanitizer sees.
class AlignedCopy {
 public:
  AlignedCopy(const unsigned char* data, std::size_t size) {
    void* block = nullptr;
    promise(posix_memalign(&block, 64, size > 0 ? size : 1) == 0, "there is memory");
    bytes_ = static_cast<unsigned char*>(block);
    for (std::size_t i = 0; i < size; ++i) bytes_[i] = data[i];
  }
  ~AlignedCopy() { std::free(bytes_); }
  AlignedCopy(const AlignedCopy&) = delete;
  AlignedCopy& operator=(const AlignedCopy&) = delete;
  unsigned char* data() { return bytes_; }

 private:
  unsigned char* bytes_ = nullptr;
};

}  // namespace palpate::fuzz
