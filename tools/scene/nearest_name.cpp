#include "tools/scene/nearest_name.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace palpate::tools {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

/// of: as in remedy_of_former, several of them between blanks.
/// names: the names that are gone, each between blanks. remedy: what a user does instead.
struct FormerNames {
  std::string_view of, names;
  const char* remedy;
};
constexpr FormerNames kFormerNames[] = {
    {"command", " bench ",
     "Benchmarks are a program of their own, palpate_bench: configure with -DPALPATE_WORKSHOP=ON."},
    {"command key", " modulus thickness ",
     "Identify the material from presses on the body: palpate calibrate SCENE --samples samples.h5 "
     "-o NEW.toml."},
    {"export", " --no-guard ", "Leave it out: every asset has the guard."},
    {"fit", " --contact-deviation ", "Write it into recordings/contact_deviation of the samples."},
    {"refine", " --follow-gap ", "Leave it out: the choice is made by leaving points out."},
    {"refine", " --slope-share ", "Leave it out: the share is chosen by leaving points out."},
    {"report", " --figures ",
     "Draw figures in Python: palpate.plot_statement, plot_curves, plot_rivals, plot_path."},
    {"key export",
     " --elsewhere contact_range element export hold_approach hold_force holds within ",
     "Leave it out: this is no longer set."},
    {"key", " repeats ", "Give recordings that are no repeats names of their own: point."},
    {"key", " disc ", "Name the place with sphere."},
    {"key", " gravity ", "Leave it out: give the shape that the body has under its weight."},
    {"key", " heading ", "Turn the mesh in its file, or play the tool as balls, [tool]."},
    {"key", " symmetric ", "Write a [[bed]] there, thin and stiff, with slides = true."},
    {"key", " max_array point_minutes task_minutes time_factor ",
     "Write limits of the scheduler into options of [cluster]."},
    {"contact", " ratio-of-variances threshold two-line ", "Leave it out, or take smooth-curve."},
    {"family", " auto ", "Leave it out: curves are rings wherever there are drags."},
    {"key format",
     " afm-workshop afmformats afmformats-hdf5 cantilever chiaro igor jpk nanoscope nt-mdt tdms ",
     "Convert the file to a table, whose columns are named in [defaults]: afmformats converts "
     "curves of microscopes, npTDMS those of LabVIEW."},
    {"shape", " ellipsoid ", "Take shape = \"mesh\" and a file of it."},
    {"shape", " pyramid ", "Take shape = \"cone\", as wide at each depth."}};

}  // namespace

std::string remedy_of_former(std::string_view of, std::string_view name) {
  const auto* former = std::ranges::find_if(kFormerNames, [&](const FormerNames& row) {
    return row.of.find(of) != std::string_view::npos &&
           row.names.find(fmt::format(" {} ", name)) != std::string_view::npos;
  });
  return former == std::end(kFormerNames) ? "" : former->remedy;
}

std::string nearest_name(std::string_view typed, const std::vector<std::string_view>& names) {
  const auto distance = [&](std::string_view name) {
    return typed.size() >= 3 && name.starts_with(typed) ? 1 : edit_distance(typed, name);
  };
  const auto best = std::min_element(names.begin(), names.end(),
                                     [&](auto a, auto b) { return distance(a) < distance(b); });
  const bool is_near =
      best != names.end() && distance(*best) <= std::max<std::size_t>(2, typed.size() / 3);
  return is_near ? std::string(*best) : std::string();
}

std::string suggestion(std::string_view typed, const std::vector<std::string_view>& names) {
  const std::string nearest = nearest_name(typed, names);
  return (nearest.empty() ? "" : fmt::format("Did you mean \"{}\"? ", nearest)) +
         fmt::format("Known: {}.", fmt::join(names, ", "));
}

}  // namespace palpate::tools
