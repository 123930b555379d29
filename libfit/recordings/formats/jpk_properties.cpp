#include "libfit/recordings/formats/jpk_properties.hpp"

#include "libfit/recordings/formats/text_file.hpp"

namespace palpate::importers::jpk {
namespace {

// Without its escapes; "\:" is ":", and so on. Letters by number (\u00b5) are not in what is read.
std::string unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size()) ++i;
    out += text[i];
  }
  return out;
}

}  // namespace

Properties properties_of(std::string_view text) {
  Properties properties;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t equals = line.find('=');
    if (line.empty() || line.front() == '#' || equals == std::string_view::npos) continue;
    properties[std::string(trimmed(line.substr(0, equals)))] =
        unescaped(trimmed(line.substr(equals + 1)));
  }
  return properties;
}

SegmentHeader::SegmentHeader(Properties own, std::shared_ptr<const Properties> shared)
    : own_(std::move(own)), shared_(std::move(shared)) {
  for (const auto& [key, value] : own_) {
    if (!key.ends_with(".*")) continue;
    const std::size_t dot = key.rfind('.', key.size() - 3);
    if (dot == std::string::npos) continue;
    const std::string kind = key.substr(dot + 1, key.size() - 2 - dot);  // "lcd-info."
    stands_for_.emplace_back(key.substr(0, dot + 1), kind + value + ".");
  }
}

std::optional<std::string> SegmentHeader::text(const std::string& key) const {
  if (const auto found = own_.find(key); found != own_.end()) return found->second;
  for (const auto& [here, there] : stands_for_)
    if (key.starts_with(here))
      if (const auto found = shared_->find(there + key.substr(here.size()));
          found != shared_->end())
        return found->second;
  return std::nullopt;
}

std::optional<double> SegmentHeader::number(const std::string& key) const {
  const auto found = text(key);
  return found ? parse_number(*found, '.') : std::nullopt;
}

std::optional<std::string> SegmentHeader::first_text(const std::vector<std::string>& keys) const {
  for (const std::string& key : keys)
    if (auto found = text(key)) return found;
  return std::nullopt;
}

std::optional<double> SegmentHeader::first_number(const std::vector<std::string>& keys) const {
  for (const std::string& key : keys)
    if (const auto found = number(key)) return found;
  return std::nullopt;
}

}  // namespace palpate::importers::jpk
