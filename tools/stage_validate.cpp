#include "tools/stage_validate.hpp"

#include <limits>

#include "libfem/solve/simulate.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/io/csv.hpp"
#include "libfit/runtime/engine.hpp"
#include "tools/console.hpp"
#include "tools/held_out.hpp"
#include "tools/stage_simulate.hpp"

namespace palpate::tools {
namespace {

constexpr double kTick_m = 20e-6;       // 20 mm/s at 1 kHz
constexpr double kApproachRatio = 0.1;  // of the depth, from outside, before the first row
constexpr std::size_t kTimedTicks = 200000;

// Follows one path with the engine from outside and returns the force ON THE BODY at each row.
class EngineFollower {
 public:
  explicit EngineFollower(const runtime::AssetView& asset) : asset_(asset) {}

  Points follow(const Vec3& point, const Vec3& normal, const Points& deflections,
                double approach_m) {
    Points force(deflections.rows(), 3);
    runtime::Contact contact;
    Vec3 deflection = -approach_m * normal;
    tick(contact, point + deflection);
    for (Eigen::Index row = 0; row < deflections.rows(); ++row) {
      const Vec3 from = deflection, way = Vec3(deflections.row(row)) - from;
      const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / kTick_m)));
      Vec3 on_body = Vec3::Zero();
      for (int k = 1; k <= steps; ++k)
        on_body = tick(contact, point + from + way * (double(k) / steps));
      deflection = deflections.row(row);
      force.row(row) = on_body;
    }
    return force;
  }

  std::size_t ticks() const { return ticks_; }

 private:
  Vec3 tick(runtime::Contact& contact, const Vec3& tip) {
    runtime::Output out;
    runtime::touch(asset_, contact, tip.data(), out);  // a status but ok comes with zero force
    ++ticks_;
    return -Vec3(out.force_on_tool_N[0], out.force_on_tool_N[1], out.force_on_tool_N[2]);
  }

  const runtime::AssetView& asset_;
  std::size_t ticks_ = 0;
};

Points follow_all(EngineFollower& engine, const HeldOut& held_out, std::size_t point,
                  double depth_m) {
  const auto i = static_cast<Eigen::Index>(point);
  return engine.follow(held_out.points.position.row(i), held_out.points.normal.row(i),
                       held_out.paths[point].deflections, kApproachRatio * depth_m);
}

// Mean wall time of a tick over repeated replays of all paths.
double time_ticks_ns(const runtime::AssetView& asset, const HeldOut& held_out, double depth_m) {
  EngineFollower engine(asset);
  const double started = wall_seconds();
  while (engine.ticks() < kTimedTicks)
    for (std::size_t point = 0; point < held_out.paths.size(); ++point)
      follow_all(engine, held_out, point, depth_m);
  return 1e9 * (wall_seconds() - started) / static_cast<double>(engine.ticks());
}

void write_rows(const std::filesystem::path& path, const Samples& reference,
                const std::vector<Points>& engine) {
  static constexpr std::string_view kHeader[] = {"point", "step", "x_m",  "y_m",  "z_m",
                                                 "dx_m",  "dy_m", "dz_m", "fx_N", "fy_N",
                                                 "fz_N",  "ex_N", "ey_N", "ez_N", "error_N"};
  CsvWriter csv(path, kHeader);
  for (Eigen::Index row = 0; row < reference.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (reference.status[r] != RowStatus::good) continue;
    const Vec3 force = reference.force.row(row);
    const Vec3 answer = engine[static_cast<std::size_t>(reference.point[r])].row(reference.step[r]);
    csv.text(reference.point_name[static_cast<std::size_t>(reference.point[r])])
        .integer(reference.step[r]);
    for (int k = 0; k < 3; ++k) csv.number(reference.point_position(reference.point[r], k));
    for (int k = 0; k < 3; ++k) csv.number(reference.deflection(row, k));
    for (int k = 0; k < 3; ++k) csv.number(force[k]);
    for (int k = 0; k < 3; ++k) csv.number(answer[k]);
    csv.number((answer - force).norm()).end_row();
  }
  csv.commit();
}

}  // namespace

Statement validate_asset(const std::filesystem::path& path, const Scene& scene, const Body& body,
                         const ValidateRequest& request) {
  const AssetFile file = read_asset_file(path);
  const runtime::AssetView& asset = file.asset();
  const double depth_m = scene.experiments.depth_m;
  const HeldOut held_out = draw_held_out(asset, {depth_m, scene.experiments.drag_distance_m},
                                         request.points, static_cast<std::uint64_t>(request.seed));
  Samples reference;
  {
    ConsoleProgress progress("validate");
    reference = fem::simulate_paths(make_simulator(scene, body), held_out.points, held_out.paths,
                                    {.jobs = job_count(request.jobs), .already_done = {}}, {},
                                    progress.progress());
  }
  if (is_interrupted()) throw Interrupted("validate: nothing was written");
  EngineFollower engine(asset);
  std::vector<Points> answers;
  for (std::size_t point = 0; point < held_out.paths.size(); ++point)
    answers.push_back(follow_all(engine, held_out, point, depth_m));
  std::vector<ComparedRow> rows;
  std::size_t failures = 0;
  for (Eigen::Index row = 0; row < reference.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (reference.status[r] != RowStatus::good) {
      ++failures;
      continue;
    }
    rows.push_back({reference.force.row(row),
                    answers[static_cast<std::size_t>(reference.point[r])].row(reference.step[r]),
                    reference.force_error[row]});
  }
  if (!request.rows_csv.empty()) write_rows(request.rows_csv, reference, answers);
  Statement statement = summarize(rows);
  statement.probes = held_out.paths.size();
  statement.reference_failures = failures;
  statement.tick_ns = time_ticks_ns(asset, held_out, depth_m);
  statement.asset_bytes = asset.file_bytes;
  return statement;
}

}  // namespace palpate::tools
