#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/error.hpp"

struct zip;

namespace palpate::importers {

/// The parts of a zip file in memory. Safe on untrusted bytes as far as libzip is: no more than
/// `max_bytes` are unpacked, all parts together. Throws Error naming file and part when it is cut
/// short, damaged, packed in a way that is not known, or encrypted.
class ZipFile {
 public:
  /// bytes: must outlive it.
  ZipFile(const std::filesystem::path& path, std::string_view bytes, std::uintmax_t max_bytes);

  const std::vector<std::string>& names() const { return names_; }
  bool has(const std::string& name) const;
  std::string read(const std::string& name);
  /// At "file#part".
  Error error(const std::string& part, const std::string& what, const std::string& remedy) const;

 private:
  std::filesystem::path path_;
  std::uintmax_t left_ = 0, max_bytes_ = 0;
  std::unique_ptr<zip, void (*)(zip*)> archive_;
  std::vector<std::string> names_;
};

}  // namespace palpate::importers
