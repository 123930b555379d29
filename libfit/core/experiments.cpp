#include "libfit/core/experiments.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

// All that an experiment is, to the bit.
class Key {
 public:
  void add(double number) {
    if (std::isnan(number)) number = kNan;
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  template <class Derived>
  void add(const Eigen::MatrixBase<Derived>& numbers) {
    for (const double number : numbers.reshaped()) add(number);
  }
  void add_place(const Points& position, const Points& normal, Eigen::Index place) {
    add(position.row(place));
    add(normal.row(place));
  }
  void add_row(const Vec3& deflection, double time_s, const Lean& lean) {
    add(deflection);
    add(time_s);
    add(lean);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

bool is_of_point(ExperimentKind kind) {
  return kind == ExperimentKind::press || kind == ExperimentKind::drag;
}

// The rows of one experiment of a list: of a test point, of all its presses and drags.
struct FoundExperiment {
  std::string key;
  std::vector<Eigen::Index> rows;
  std::int32_t first_number = 0;
};

std::string key_of(const Samples& samples, const std::vector<Eigen::Index>& rows) {
  const auto first = static_cast<std::size_t>(rows.front());
  const ExperimentKind kind =
      is_of_point(samples.kind[first]) ? ExperimentKind::press : samples.kind[first];
  const std::int32_t place = samples.point[first];
  Key key;
  key.add(static_cast<double>(kind));
  key.add(samples.probe_of(first));
  key.add_place(samples.point_position, samples.point_normal, place);
  if (is_of_point(kind)) {
    key.add(std::ranges::any_of(
        rows, [&](Eigen::Index row) { return samples.kind[row] == ExperimentKind::drag; }));
    key.add(samples.point_scale.size() > 0 ? samples.point_scale[place] : 0);
    return key.bytes();
  }
  for (const Eigen::Index row : rows)
    if (samples.tool_of(row) == 0)
      key.add_row(samples.deflection.row(row), samples.time_of(row), samples.lean_at(row));
  bool is_first = true;
  for (const Eigen::Index row : rows) {
    if (samples.tool_of(row) == 0) continue;
    if (is_first) key.add_place(samples.point_position, samples.point_normal, samples.point[row]);
    is_first = false;
    key.add(samples.deflection.row(row));
  }
  return key.bytes();
}

std::vector<FoundExperiment> experiments_in(const Samples& samples) {
  std::vector<FoundExperiment> out;
  std::map<std::int32_t, std::size_t> of_point;  // presses and drags of a place
  std::map<std::int32_t, std::size_t> of_number;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    auto& index = is_of_point(samples.kind[row]) ? of_point : of_number;
    const auto [at, is_new] = index.emplace(
        is_of_point(samples.kind[row]) ? samples.point[row] : samples.experiment[row], out.size());
    if (is_new) out.push_back({{}, {}, samples.experiment[row]});
    out[at->second].rows.push_back(row);
  }
  for (FoundExperiment& found : out) found.key = key_of(samples, found.rows);
  return out;
}

// Rows of experiments, each with the number that its first one gets.
struct Renumbered {
  std::vector<Eigen::Index> rows;
  std::vector<std::int32_t> experiment;

  void add(const Samples& from, const FoundExperiment& found, std::int32_t first_number) {
    for (const Eigen::Index row : found.rows) {
      rows.push_back(row);
      experiment.push_back(first_number + from.experiment[row] - found.first_number);
    }
  }
};

void copy_place(const Samples& from, Eigen::Index place, Samples& to, Eigen::Index at) {
  each_point_column([&](auto, auto column, auto&&, auto... fill) {
    if constexpr (sizeof...(fill) > 0)
      if ((from.*column).rows() > 0) (to.*column).row(at) = (from.*column).row(place);
  });
}

Samples at_places(const TestPoints& places, const Samples& like) {
  Samples out;
  out.point_position = places.position;
  out.point_normal = places.normal;
  out.point_name = places.name;
  out.point_normal_gradient.setZero(places.position.rows(), 9);
  if (like.point_sway.rows() > 0) out.point_sway.setZero(places.position.rows(), 6);
  out.point_scale.setZero(places.position.rows());
  out.relaxation = like.relaxation;
  return out;
}

}  // namespace

ExperimentList experiments_at(const TestPoints& points, const std::vector<Effort>& effort) {
  ExperimentList out{points, {}};
  for (Eigen::Index p = 0; p < points.position.rows(); ++p)
    out.experiments.push_back({ExperimentKind::press,
                               static_cast<std::int32_t>(p),
                               effort.empty() ? Effort{true, 0} : effort[p],
                               {},
                               0});
  return out;
}

ExperimentList paths_at(const TestPoints& points, const std::vector<ToolPath>& paths,
                        ExperimentKind kind, std::int32_t probe_number) {
  ExperimentList out{points, {}};
  for (const ToolPath& path : paths) {
    if (path.point < 0 || path.point >= points.position.rows())
      throw Error("paths",
                  "path names test point " + std::to_string(path.point) + ", which does not exist",
                  "Number test points from 0.");
    out.experiments.push_back({kind, path.point, {}, path, probe_number});
    if (!path.second) continue;
    out.experiments.back().path.second->place =
        static_cast<std::int32_t>(out.places.position.rows());
    out.places.add(path.second->position, path.second->normal, points.name[path.point] + "b");
  }
  return out;
}

void append(ExperimentList& to, const ExperimentList& more) {
  std::map<std::string, std::int32_t> known;
  const auto key_at = [](const TestPoints& places, Eigen::Index place) {
    Key key;
    key.add_place(places.position, places.normal, place);
    return key.bytes();
  };
  for (Eigen::Index p = 0; p < to.places.position.rows(); ++p)
    known.emplace(key_at(to.places, p), static_cast<std::int32_t>(p));
  std::vector<std::int32_t> number;
  for (Eigen::Index p = 0; p < more.places.position.rows(); ++p) {
    const auto places = static_cast<std::int32_t>(to.places.position.rows());
    const auto [at, is_new] = known.emplace(key_at(more.places, p), places);
    if (is_new)
      to.places.add(more.places.position.row(p), more.places.normal.row(p), more.places.name[p]);
    number.push_back(at->second);
  }
  for (Experiment one : more.experiments) {
    one.place = one.path.point = number[one.place];
    if (one.path.second) one.path.second->place = number[one.path.second->place];
    to.experiments.push_back(std::move(one));
  }
}

ExperimentList taken(const ExperimentList& list, const std::vector<std::size_t>& which) {
  ExperimentList out;
  std::map<std::int32_t, std::int32_t> number;
  std::vector<std::int32_t> places;
  const auto renumber = [&](std::int32_t place) {
    const auto [at, is_new] = number.emplace(place, static_cast<std::int32_t>(number.size()));
    if (is_new) places.push_back(place);
    return at->second;
  };
  for (const std::size_t i : which) {
    Experiment one = list.experiments[i];
    one.place = one.path.point = renumber(one.place);
    if (one.path.second) one.path.second->place = renumber(one.path.second->place);
    out.experiments.push_back(std::move(one));
  }
  out.places.position = list.places.position(places, Eigen::all);
  out.places.normal = list.places.normal(places, Eigen::all);
  out.places.triangles.resize(0, 3);
  for (const std::int32_t place : places) out.places.name.push_back(list.places.name[place]);
  return out;
}

std::vector<std::int32_t> first_numbers(const ExperimentList& list, int per_point) {
  std::vector<std::int32_t> out;
  std::int32_t next = 0;
  for (const Experiment& one : list.experiments) {
    out.push_back(next);
    next += is_of_point(one.kind) ? per_point : 1;
  }
  return out;
}

Samples planned_rows(const ExperimentList& list) {
  Samples out = at_places(list.places, {});
  std::vector<Vec3> deflection;
  std::vector<double> time_s;
  std::vector<Lean> lean;
  const auto add = [&](const Experiment& one, ExperimentKind kind, std::int32_t number,
                       Eigen::Index step, int tool, const Vec3& to) {
    out.point.push_back(tool == 0 ? one.place : one.path.second->place);
    out.experiment.push_back(number);
    out.kind.push_back(kind);
    out.step.push_back(static_cast<std::int32_t>(step));
    out.tool.push_back(tool);
    out.probe_number.push_back(one.probe_number);
    out.path.push_back(one.path.kind);
    out.status.push_back(RowStatus::not_reached);
    deflection.push_back(to);
    time_s.push_back(one.path.time_of(step));
    lean.push_back(one.path.lean);
  };
  const std::vector<std::int32_t> number = first_numbers(list, 2);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Experiment& one = list.experiments[i];
    if (is_of_point(one.kind)) {
      add(one, ExperimentKind::press, number[i], 0, 0, Vec3::Zero());
      if (one.effort.is_dragged) add(one, ExperimentKind::drag, number[i] + 1, 0, 0, Vec3::Zero());
      out.point_scale[one.place] = one.effort.scale;
      continue;
    }
    for (Eigen::Index row = 0; row < one.path.deflections.rows(); ++row) {
      add(one, one.kind, number[i], row, 0, one.path.deflections.row(row));
      if (one.path.second)
        add(one, one.kind, number[i], row, 1, one.path.second->deflections.row(row));
    }
  }
  const Eigen::Index rows = std::ssize(deflection);
  out.force = out.torque = Points::Zero(rows, 3);
  out.force_error.setConstant(rows, kNan);
  out.deflection.resize(rows, 3);
  out.time_s.resize(rows);
  out.lean.resize(rows, 2);
  for (Eigen::Index row = 0; row < rows; ++row) {
    out.deflection.row(row) = deflection[row];
    out.time_s[row] = time_s[row];
    out.lean.row(row) = lean[row];
  }
  remove_void_columns(out);
  return out;
}

ExperimentList list_of(const Samples& planned) {
  ExperimentList out{
      {planned.point_position, planned.point_normal, planned.point_name, Triangles(0, 3)}, {}};
  for (const FoundExperiment& found : experiments_in(planned)) {
    const Eigen::Index first = found.rows.front();
    Experiment& one = out.experiments.emplace_back();
    one.place = one.path.point = planned.point[first];
    one.probe_number = planned.probe_of(first);
    if (is_of_point(planned.kind[first])) {
      one.effort = {found.rows.size() > 1, planned.point_scale[one.place]};
      continue;
    }
    one.kind = planned.kind[first];
    one.path.kind = planned.path_of(first);
    one.path.lean = planned.lean_at(first);
    std::vector<Eigen::Index> of_first, of_second;
    for (const Eigen::Index row : found.rows)
      (planned.tool_of(row) == 0 ? of_first : of_second).push_back(row);
    one.path.deflections = planned.deflection(of_first, Eigen::all);
    if (!std::isnan(planned.time_of(first))) one.path.time_s = planned.time_s(of_first);
    if (of_second.empty()) continue;
    const std::int32_t place = planned.point[of_second.front()];
    one.path.second = SecondTool{planned.point_position.row(place), planned.point_normal.row(place),
                                 planned.deflection(of_second, Eigen::all), place};
  }
  return out;
}

Samples known_rows(const ExperimentList& wanted, const Samples& known, int per_point) {
  const std::vector<FoundExperiment> all = experiments_in(known);
  std::map<std::string, const FoundExperiment*> by_key;
  for (const FoundExperiment& found : all) by_key.emplace(found.key, &found);
  const std::vector<FoundExperiment> planned = experiments_in(planned_rows(wanted));
  const std::vector<std::int32_t> number = first_numbers(wanted, per_point);
  Samples out = at_places(wanted.places, known);
  Renumbered taken;
  std::vector<std::int32_t> place;
  // The first experiment that is known at a place supplies its columns, whatever file it is from.
  std::vector<char> has_columns(out.points(), 0);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Experiment& one = wanted.experiments[i];
    const auto at = by_key.find(planned[i].key);
    if (at == by_key.end()) continue;
    taken.add(known, *at->second, number[i]);
    for (const Eigen::Index row : at->second->rows) {
      const bool is_second = known.tool_of(row) > 0;
      place.push_back(is_second ? one.path.second->place : one.place);
      if (!has_columns[place.back()]) copy_place(known, known.point[row], out, place.back());
    }
    has_columns[one.place] = 1;
  }
  append_rows(out, known, taken.rows);
  if (taken.rows.empty()) out.surface.resize(0, known.surface.cols());
  out.point = std::move(place);
  out.experiment = std::move(taken.experiment);
  return out;
}

std::vector<std::size_t> without_rows(const ExperimentList& list, const Samples& samples,
                                      int per_point) {
  const std::vector<std::int32_t> number = first_numbers(list, per_point);
  const std::set<std::int32_t> has(samples.experiment.begin(), samples.experiment.end());
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!has.contains(number[i])) out.push_back(i);
  return out;
}

Samples beyond(const Samples& samples, const ExperimentList& list) {
  std::set<std::string> known;
  for (const FoundExperiment& one : experiments_in(planned_rows(list))) known.insert(one.key);
  Samples out =
      at_places({samples.point_position, samples.point_normal, samples.point_name, {}}, samples);
  for (Eigen::Index p = 0; p < samples.points(); ++p) copy_place(samples, p, out, p);
  Renumbered left;
  for (const FoundExperiment& found : experiments_in(samples))
    if (known.insert(found.key).second) left.add(samples, found, found.first_number);
  append_rows(out, samples, left.rows);
  return out;
}

}  // namespace palpate
