#pragma once

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

namespace palpate::tools {

namespace py = pybind11;

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// Numbers [n, columns], or [columns] for n = 1, as doubles without a gap. Copies only what is not.
struct Rows {
  Array<double> values;
  py::ssize_t count;
  bool is_single;
};
inline Rows rows_of(const char* name, const py::object& given, py::ssize_t columns) {
  const py::array any = py::array::ensure(given);
  if (!any || std::strchr("fiu", any.dtype().kind()) == nullptr)
    throw py::type_error(std::string(name) + " must be real numbers");
  const bool is_single = any.ndim() == 1;
  if ((any.ndim() != 2 && !is_single) || any.shape(any.ndim() - 1) != columns)
    throw py::value_error(std::string(name) + " must have the shape (n, " +
                          std::to_string(columns) + "), or (" + std::to_string(columns) + ",)");
  return {Array<double>(any), is_single ? 1 : any.shape(0), is_single};
}

/// One row for all ticks, or one each; a default where None is given.
template <std::size_t N>
class PerTick {
 public:
  PerTick(const char* name, const py::object& given, const std::array<double, N>& otherwise,
          py::ssize_t ticks)
      : constant_(otherwise) {
    if (given.is_none()) return;
    rows_ = rows_of(name, given, N);
    if (!rows_->is_single && rows_->count != ticks)
      throw py::value_error(std::string(name) + " has " + std::to_string(rows_->count) +
                            " rows, position_m " + std::to_string(ticks));
    data_ = rows_->values.data();
    stride_ = rows_->is_single ? 0 : N;
  }
  void copy(py::ssize_t tick, double* to) const {
    const double* from =
        data_ ? data_ + static_cast<std::size_t>(tick) * stride_ : constant_.data();
    std::copy_n(from, N, to);
  }

 private:
  std::array<double, N> constant_;
  std::optional<Rows> rows_;
  const double* data_ = nullptr;
  std::size_t stride_ = 0;
};

}  // namespace palpate::tools
