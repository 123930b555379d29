#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "libfem/calibrate/pressed_body.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/stages/samples/sample_cache.hpp"

namespace palpate::tools {

/// Presses that were simulated, beside the output until it is written.
class PressCache {
 public:
  PressCache(const std::string& output, std::string fingerprint, bool resume,
             fem::PressedBody& body)
      : path_(output + ".partial"), fingerprint_(std::move(fingerprint)), body_(body) {
    if (std::filesystem::exists(path_)) {
      const Json kept = resume ? Json::parse(read_whole_file(path_), nullptr, false) : Json();
      if (!resume)
        say("  {} of an interrupted run is not used (no --resume)", path_);
      else if (!kept.is_object() || kept.value("made_from", "") != fingerprint_)
        say("  {} was made from something else and is not used", path_);
      else
        take(kept);
    }
    body_.on_press = [this] { clock_.keep([this] { keep(); }); };
  }
  void keep() const {
    Json presses = Json::object();
    for (const auto& [name, press] : body_.known)
      presses[name] = {{"force_N", press.force_N}, {"error_N", press.error_N}};
    write_file_atomically(path_, Json{{"made_from", fingerprint_}, {"presses", presses}}.dump());
  }
  void remove() const {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  const std::string& path() const { return path_; }

 private:
  using Json = nlohmann::ordered_json;

  void take(const Json& kept) {
    try {
      for (const auto& [name, press] : kept.at("presses").items()) {
        fem::SimulatedPress& known = body_.known[name];
        known.force_N = press.at("force_N").get<std::vector<double>>();
        for (const Json& error : press.at("error_N"))
          known.error_N.push_back(error.is_number() ? error.get<double>() : NAN);
      }
      say("  resuming: {} presses are done", body_.known.size());
    } catch (const Json::exception&) {
      body_.known.clear();
    }
  }

  std::string path_, fingerprint_;
  fem::PressedBody& body_;
  KeepClock clock_;
};

}  // namespace palpate::tools
