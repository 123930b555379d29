#include "tools/workshop/rivals/felt.hpp"

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/content_hash.hpp"
#include "tools/report/packed.hpp"

namespace palpate::tools {
namespace {

constexpr double kCheckStep_m = 0.1e-3;

std::vector<double> numbers(const Vec3& v) { return {v[0], v[1], v[2]}; }

// Places of a tool from outside along the first held-out path.
std::vector<Vec3> check_path(const RivalBody& body) {
  const Samples& paths = body.paths;
  const Vec3 position = paths.point_position.row(paths.point.front()),
             inward = paths.point_normal.row(paths.point.front());
  std::vector<Vec3> out{position - kApproachRatio * body.depth_m * inward};
  for (Eigen::Index row = 0;
       row < paths.rows() &&
       paths.experiment[static_cast<std::size_t>(row)] == paths.experiment.front();
       ++row) {
    const Vec3 from = out.back(), to = position + Vec3(paths.deflection.row(row));
    const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kCheckStep_m)));
    for (int k = 1; k <= steps; ++k) out.push_back(from + (to - from) * (double(k) / steps));
  }
  return out;
}

}  // namespace

void write_felt(const std::filesystem::path& run, const std::vector<Rival>& rivals,
                const RivalBody& body) {
  const std::vector<Vec3> path = check_path(body);
  const Vec3 inward = body.paths.point_normal.row(body.paths.point.front());
  Json felt = Json::array(), check{{"inward", numbers(inward)}};
  for (const Vec3& place : path) check["tip_m"].push_back(numbers(place));
  for (const Rival& rival : rivals) {
    if (rival.felt.empty()) continue;
    Json one = Json::parse(rival.felt);
    one["name"] = rival.name;
    one["settings"] = rival.settings;
    felt.push_back(std::move(one));
    Json forces = Json::array();
    rival.start(inward);
    for (const Vec3& place : path) forces.push_back(numbers(rival.force(place)));
    check["force_N"].push_back(std::move(forces));
  }
  const Json file{{"schema", "palpate-rivals"},
                  {"version", 1},
                  {"asset", ContentHash().add_file(run / "asset.palp").hex()},
                  {"rivals", felt},
                  {"check", check}};
  write_file_atomically(run / "rivals.json", file.dump() + "\n");
}

}  // namespace palpate::tools
