#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "libfit/runtime/palpate.h"

// Arrays, an asset, and its contacts.

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

inline std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

[[noreturn]] inline void refuse_tool_or_bytes(const std::string& where, palpate_status status) {
  const py::object error = py::module_::import("palpate").attr("Error");
  PyErr_SetObject(error.ptr(), error(where, palpate_sentence(status), "").ptr());
  throw py::error_already_set();
}

// An opened asset with its bytes; contacts share it, so that closing pulls nothing from under them.
class PyAsset {
 public:
  PyAsset(const py::bytes& content, const std::string& where) {
    char* bytes = nullptr;
    py::ssize_t size = 0;
    if (PyBytes_AsStringAndSize(content.ptr(), &bytes, &size) != 0) throw py::error_already_set();
    const auto count = static_cast<std::uint64_t>(size);
    palpate_status status;
    {
      const py::gil_scoped_release other_threads;
      room_.resize(count + 63);
      status = palpate_open(&asset_, palpate_copy_aligned(room_.data(), room_.size(), bytes, count),
                            count);
    }
    if (status != PALPATE_OK) refuse_tool_or_bytes(where, status);
    palpate_describe(&asset_, &info_);
    palpate_read_mesh(&asset_, &mesh_);
  }
  const palpate_asset* open() const {
    if (is_closed_) throw py::value_error("the asset is closed");
    return &asset_;
  }
  const palpate_info& info() const { return open(), info_; }
  const palpate_mesh& mesh() const { return open(), mesh_; }
  // Its bytes go with the last contact.
  void close() { is_closed_ = true; }
  bool is_closed() const { return is_closed_; }

 private:
  std::vector<char> room_;
  palpate_asset asset_;
  palpate_info info_;
  palpate_mesh mesh_;
  bool is_closed_ = false;  // under the GIL
};

inline py::array_t<double> vertices_of(const PyAsset& asset) {
  const palpate_mesh& mesh = asset.mesh();
  py::array_t<double> out({mesh.vertices, 3});
  for (int i = 0; i < 3 * mesh.vertices; ++i)
    out.mutable_data()[i] = mesh.origin_m[i % 3] + static_cast<double>(mesh.vertex_m[i]);
  return out;
}

// The asset as the balls of a tool meet it, where they are others than that of its curves.
struct MetBalls {
  std::array<palpate_asset, PALPATE_MAX_BALLS> asset;
  std::array<std::vector<std::uint64_t>, PALPATE_MAX_BALLS> memory;
};

// One tool on one asset. A tick holds its mutex: threads take turns.
class PyContact {
 public:
  // end: how a tool of one ball ends that is no ball.
  PyContact(std::shared_ptr<const PyAsset> asset, const palpate_tool& tool,
            const std::optional<palpate_indenter>& end = {})
      : asset_(std::move(asset)), tool_(tool) {
    asset_->open();
    if (tool_.balls > 1 && asset_->info().couples == 0)
      refuse_tool_or_bytes("tool", PALPATE_TOOL_WRONG);
    check_size();
    meet(end);
    start();
  }
  PyContact(const PyContact& other) : asset_(other.asset_), met_(other.met_), tool_(other.tool_) {
    const py::gil_scoped_release other_threads;
    const std::lock_guard lock(other.mutex_);
    contact_ = other.contact_;
  }
  void start() {
    if (const palpate_status status = locked([&] { return palpate_start(&contact_, &tool_); });
        status != PALPATE_OK)
      refuse_tool_or_bytes("tool", status);
  }
  void release() {
    locked([&] { return palpate_release(&contact_); });
  }
  const std::shared_ptr<const PyAsset>& asset() const { return asset_; }

 private:
  friend class Together;
  friend class PyBatch;

  template <class F>
  palpate_status locked(F&& work) {
    const py::gil_scoped_release other_threads;
    const std::lock_guard lock(mutex_);
    return work();
  }

  // A ball larger than the probe and than twice the body is a plate to it: its unit is wrong.
  void check_size() const {
    const palpate_info& info = asset_->info();
    double extent_m = 0;
    for (int axis = 0; axis < 3; ++axis)
      extent_m = std::hypot(extent_m, info.box_max_m[axis] - info.box_min_m[axis]);
    for (int i = 0; i < tool_.balls; ++i)
      if (tool_.radius_m[i] > std::max(2 * extent_m, info.probe_radius_m))
        throw py::value_error("radius_m is " + shown(tool_.radius_m[i]) + ", and the body is " +
                              shown(extent_m) + " m long; is it in metres?");
  }

  void meet(const std::optional<palpate_indenter>& end) {
    const double own_m = asset_->info().probe_radius_m;
    const std::uint64_t bytes = palpate_indenter_bytes(asset_->open());
    for (int i = 0; i < tool_.balls && bytes > 0; ++i) {
      const double radius_m = tool_.radius_m[i];
      if (!end && (!(radius_m > 0) || radius_m == own_m)) continue;
      if (!met_) met_ = std::make_shared<MetBalls>();
      const auto at = static_cast<std::size_t>(i);
      met_->memory[at].resize(bytes / sizeof(std::uint64_t));
      const palpate_indenter indenter = end ? *end : palpate_ball_indenter(radius_m);
      const palpate_status status = palpate_indenter_open(
          &met_->asset[at], asset_->open(), &indenter, met_->memory[at].data(), bytes);
      if (status != PALPATE_OK) refuse_tool_or_bytes("tool", status);
      tool_.ball_asset[i] = &met_->asset[at];
    }
  }

  std::shared_ptr<const PyAsset> asset_;
  std::shared_ptr<MetBalls> met_;  // that tool_ points to
  palpate_tool tool_;
  palpate_contact contact_{};
  mutable std::mutex mutex_;
};

// Tools on one asset for one call: their contacts side by side, as the engine wants them, and back
// in their places afterwards. Locks are taken in one order everywhere.
class Together {
 public:
  explicit Together(const std::vector<PyContact*>& tools) : tools_(tools), locked_(tools) {
    if (tools.empty() || tools.size() > PALPATE_MAX_BALLS)
      throw py::value_error("1 to " + std::to_string(PALPATE_MAX_BALLS) +
                            " contacts go together, not " + std::to_string(tools.size()));
    std::sort(locked_.begin(), locked_.end());
    if (std::adjacent_find(locked_.begin(), locked_.end()) != locked_.end())
      throw py::value_error("a contact is there twice");
    for (const PyContact* tool : tools)
      if (tool->asset_ != tools[0]->asset_)
        throw py::value_error("contacts that go together are on one asset");
    asset_ = tools[0]->asset_->open();
    contacts_.resize(tools.size());
  }

  const palpate_asset* asset() const { return asset_; }
  std::int32_t count() const { return static_cast<std::int32_t>(tools_.size()); }

  /// work(contacts), without the GIL.
  template <class F>
  palpate_status locked(F&& work) {
    const py::gil_scoped_release other_threads;
    for (PyContact* tool : locked_) tool->mutex_.lock();
    if (tools_.size() == 1) {
      const palpate_status status = work(&tools_[0]->contact_);
      tools_[0]->mutex_.unlock();
      return status;
    }
    for (std::size_t k = 0; k < tools_.size(); ++k) contacts_[k] = tools_[k]->contact_;
    const palpate_status status = work(contacts_.data());
    for (std::size_t k = 0; k < tools_.size(); ++k) tools_[k]->contact_ = contacts_[k];
    for (PyContact* tool : locked_) tool->mutex_.unlock();
    return status;
  }

 private:
  std::vector<PyContact*> tools_, locked_;
  std::vector<palpate_contact> contacts_;
  const palpate_asset* asset_;
};

// Many tools on an asset that know nothing of each other: copies of one, a state each.
class PyBatch {
 public:
  PyBatch(const PyContact& tool, py::ssize_t count) : tool_(tool) {
    if (count < 1) throw py::value_error("a batch has 1 contact or more");
    contacts_.assign(static_cast<std::size_t>(count), tool_.contact_);
  }
  py::ssize_t count() const { return static_cast<py::ssize_t>(contacts_.size()); }
  // Only those that are marked; empty: all.
  void restart(const std::vector<bool>& which) {
    if (!which.empty() && which.size() != contacts_.size())
      throw py::value_error("`which` has one truth value a contact");
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (which.empty() || which[i]) contacts_[i] = tool_.contact_;
  }
  // work(contact, i) of all, shared out evenly; what a contact answers depends on itself alone.
  template <class F>
  void each(int jobs, const F& work) {
    const py::gil_scoped_release other_threads;
    const std::lock_guard lock(mutex_);
    const std::size_t cores = std::max(1u, std::thread::hardware_concurrency()),
                      wanted = jobs > 0 ? static_cast<std::size_t>(jobs) : cores,
                      threads = std::min(wanted, contacts_.size());
    const auto share = [&](std::size_t k) {
      for (std::size_t i = k * contacts_.size() / threads,
                       end = (k + 1) * contacts_.size() / threads;
           i < end; ++i)
        work(contacts_[i], static_cast<py::ssize_t>(i));
    };
    std::vector<std::thread> others;
    for (std::size_t k = 1; k < threads; ++k) others.emplace_back(share, k);
    share(0);
    for (std::thread& other : others) other.join();
  }
  const palpate_asset* asset() const { return tool_.asset_->open(); }

 private:
  PyContact tool_;  // as it was started, with what its indenter needs
  std::vector<palpate_contact> contacts_;
  std::mutex mutex_;
};

}  // namespace palpate::tools
