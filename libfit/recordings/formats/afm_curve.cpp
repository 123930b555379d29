#include "libfit/recordings/formats/afm_curve.hpp"

#include <fmt/core.h>

#include <cmath>

#include "libfit/core/text.hpp"

namespace palpate::importers {
namespace {

constexpr double kLargestNumber = 1e15;  // as in text files

bool is_positive(double value) { return value > 0 && std::isfinite(value); }

}  // namespace

Cantilever cantilever_of(const ReadSettings& settings, const Cantilever& stated,
                         const FailCantilever& fail, RawRecording& out, bool is_bent_in_metres) {
  Cantilever used = settings.cantilever.value_or(Cantilever{});
  if (!is_positive(used.stiffness_N_m) && is_positive(stated.stiffness_N_m)) {
    used.stiffness_N_m = stated.stiffness_N_m;
    out.taken.push_back("spring constant " + number(used.stiffness_N_m, 4) + " N/m");
  }
  if (!is_positive(used.sensitivity_m) && is_positive(stated.sensitivity_m)) {
    used.sensitivity_m = stated.sensitivity_m;
    out.taken.push_back("sensitivity " + number(1e9 * used.sensitivity_m, 4) + " nm per unit");
  }
  const bool has_stiffness = is_positive(used.stiffness_N_m),
             has_sensitivity = is_positive(used.sensitivity_m) || is_bent_in_metres;
  const std::string stiffness = has_stiffness ? "" : "stiffness = 0.1",
                    sensitivity = has_sensitivity ? "" : "sensitivity = \"60 nm\"",
                    both = !has_stiffness && !has_sensitivity ? ", " : "";
  if (!has_stiffness || !has_sensitivity)
    throw fail(has_stiffness     ? "states no sensitivity of the cantilever's signal"
               : has_sensitivity ? "states no spring constant"
                                 : "the force is a raw cantilever signal",
               "Say cantilever = { " + stiffness + both + sensitivity + " } in the manifest: " +
                   (has_stiffness ? "" : "N/m") + both + (both.empty() ? "" : "and ") +
                   (has_sensitivity ? "" : "deflection per unit of the signal") + ".");
  out.cantilever = used;
  out.is_force_from_signal = is_positive(used.sensitivity_m);
  return used;
}

std::vector<double> bent_by(const Cantilever& cantilever, const std::vector<double>& signal) {
  std::vector<double> bent_m;
  for (const double value : signal)
    bent_m.push_back((value - signal.front()) * cantilever.sensitivity_m);
  return bent_m;
}

void bend_cantilever(const Cantilever& cantilever, const std::vector<double>& scanner_m,
                     const std::vector<double>& bent_m, RawRecording& out) {
  for (std::size_t i = 0; i < bent_m.size(); ++i) {
    out.push_N.push_back(bent_m[i] * cantilever.stiffness_N_m);
    out.travel_m.push_back(scanner_m[i] - bent_m[i]);
  }
}

void place_in_plane(double x_m, double y_m, RawRecording& out) {
  if (!(std::abs(x_m) <= kLargestNumber) || !(std::abs(y_m) <= kLargestNumber)) return;
  out.contact_m = Vec3(x_m, y_m, 0);
  out.normal = -Vec3::UnitZ();
}

std::vector<RawRecording> read_each(const std::filesystem::path& path,
                                    const std::vector<std::string>& names,
                                    const std::function<RawRecording(const std::string&)>& read) {
  std::vector<RawRecording> recordings;
  bool is_any_read = false;
  for (const std::string& name : names) {
    RawRecording r;
    try {
      r = read(name);
      is_any_read = true;
    } catch (const Error& error) {
      if (names.size() == 1 || error.where() == path.string()) throw;
      r.unread = error;
    }
    r.name = name;
    recordings.push_back(std::move(r));
  }
  if (!is_any_read) throw *recordings.front().unread;
  return recordings;
}

void check_numbers(const RawRecording& recording, const FailCantilever& fail) {
  for (const auto* values : {&recording.time_s, &recording.travel_m, &recording.push_N})
    for (std::size_t i = 0; i < values->size(); ++i)
      if (!(std::abs((*values)[i]) <= kLargestNumber))
        throw fail(fmt::format("row {} is not a number in range", i + 1),
                   "Export the curve again, or leave it out.");
}

}  // namespace palpate::importers
