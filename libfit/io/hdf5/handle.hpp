#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace palpate::h5 {

/// Owns one HDF5 identifier (hid_t) and gives it back with the function that suits its kind.
class Handle {
 public:
  using Close = int (*)(std::int64_t);

  Handle() = default;
  Handle(std::int64_t id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = std::exchange(other.id_, -1);
      close_ = other.close_;
    }
    return *this;
  }
  ~Handle() { reset(); }

  std::int64_t id() const { return id_; }
  bool is_valid() const { return id_ >= 0; }
  /// Hands the identifier over; the caller closes it.
  std::int64_t release() { return std::exchange(id_, -1); }
  void reset() {
    if (id_ >= 0) close_(id_);
    id_ = -1;
  }

 private:
  std::int64_t id_ = -1;
  Close close_ = nullptr;
};

/// Stops HDF5 from printing its error stack; for the calling thread.
void silence();

/// Root cause in HDF5's own words from its error stack, "" without one; clears the stack.
std::string take_reason();

}  // namespace palpate::h5
