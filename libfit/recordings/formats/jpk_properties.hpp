#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

// The headers of JPK files: Java property files that refer to one another.

namespace palpate::importers::jpk {

using Properties = std::unordered_map<std::string, std::string>;

/// Keys and values of a Java property file ("key=value", '#' comments, backslash escapes); what is
/// no such line is left out. Safe on untrusted bytes.
Properties properties_of(std::string_view text);

/// The header of a segment, and what it refers to in the header that all share:
/// "channel.height.lcd-info.*=0" puts "lcd-info.0.KEY" there behind "channel.height.KEY" here.
class SegmentHeader {
 public:
  SegmentHeader(Properties own, std::shared_ptr<const Properties> shared);

  std::optional<std::string> text(const std::string& key) const;
  /// Finite; nothing where it is no number.
  std::optional<double> number(const std::string& key) const;
  /// Of the first of these keys that is there.
  std::optional<std::string> first_text(const std::vector<std::string>& keys) const;
  std::optional<double> first_number(const std::vector<std::string>& keys) const;

 private:
  Properties own_;
  std::shared_ptr<const Properties> shared_;
  std::vector<std::pair<std::string, std::string>> stands_for_;  // "channel.height.", "lcd-info.0."
};

}  // namespace palpate::importers::jpk
