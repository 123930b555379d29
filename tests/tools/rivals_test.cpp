// Rivals answer as their own theory says, and what is measured of them is what they did.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "libfem/mesh/boundary.hpp"
#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/libfem/solve/block.hpp"
#include "tests/libfit/runtime/models.hpp"
#include "tools/bench/figure.hpp"
#include "tools/bench/rivals/bullet_body.hpp"
#include "tools/bench/rivals/corotational.hpp"
#include "tools/bench/rivals/green.hpp"
#include "tools/bench/rivals/measure.hpp"
#include "tools/bench/rivals/mujoco.hpp"
#include "tools/bench/rivals/rivals.hpp"
#include "tools/bench/rivals/total_lagrangian.hpp"

namespace palpate::tools {
namespace {

constexpr double kStiffness_N_m = 400, kCone = 0.25;

// A plate whose presses are a spring's and whose drags end on a cone.
Samples plate_samples() {
  Samples samples;
  samples.point_position = Points::Zero(2, 3);
  samples.point_position.row(1) << 0.01, 0, 0;
  samples.point_normal = -Vec3::UnitZ().transpose().replicate(2, 1);
  samples.point_name = {"a", "b"};
  const auto add = [&](int point, int experiment, ExperimentKind kind, int step, const Vec3& at,
                       const Vec3& force) {
    const Eigen::Index row = samples.rows();
    samples.deflection.conservativeResize(row + 1, 3);
    samples.force.conservativeResize(row + 1, 3);
    samples.deflection.row(row) = at.transpose();
    samples.force.row(row) = force.transpose();
    samples.point.push_back(point);
    samples.experiment.push_back(experiment);
    samples.kind.push_back(kind);
    samples.step.push_back(step);
    samples.status.push_back(RowStatus::good);
  };
  for (int point = 0; point < 2; ++point) {
    for (int step = 1; step <= 4; ++step)
      add(point, 2 * point, ExperimentKind::press, step, {0, 0, -1e-3 * step},
          {0, 0, -1e-3 * step * kStiffness_N_m});
    add(point, 2 * point + 1, ExperimentKind::drag, 0, {5e-3, 0, -4e-3},
        {kCone * 4e-3 * kStiffness_N_m, 0, -4e-3 * kStiffness_N_m});
  }
  samples.force_error = Eigen::VectorXd::Zero(samples.rows());
  samples.torque = Points::Zero(samples.rows(), 3);
  return samples;
}

class Proxies : public testing::Test {
 protected:
  Proxies() {
    const std::filesystem::path path =
        std::filesystem::path(testing::TempDir()) / "rivals_plate.palp";
    export_palp(test::plate_model(0.1, 20, test::uniform(400, 300, 0.3)), path, {});
    body_.asset = read_asset_file(path);
    body_.samples = plate_samples();
  }

  RivalBody body_;
};

// Presses 2 mm deep from outside, beside the first test point, then slides.
Vec3 press_and_slide(const Rival& rival, double slide_m) {
  rival.start(-Vec3::UnitZ());
  Vec3 force = Vec3::Zero();
  for (int k = 0; k <= 40; ++k) force = rival.force({1e-4, 1.3e-4, 1e-4 * (20 - k)});
  for (int k = 1; k <= 100; ++k) force = rival.force({1e-4 + slide_m * k / 100, 1.3e-4, -2e-3});
  return force;
}

TEST_F(Proxies, press_as_the_samples_do_and_slide_on_their_cone) {
  for (const auto prepare : {prepare_proxy, prepare_proxy_on_curves}) {
    const std::vector<Rival> rivals = prepare(body_);
    ASSERT_EQ(rivals.size(), 1U);
    const Vec3 pressed = press_and_slide(rivals[0], 0), slid = press_and_slide(rivals[0], 6e-3);
    EXPECT_NEAR(pressed.z(), -2e-3 * kStiffness_N_m, 1e-6) << rivals[0].name;
    EXPECT_NEAR(pressed.head<2>().norm(), 0, 1e-9) << rivals[0].name;
    EXPECT_NEAR(slid.x() / -slid.z(), kCone, 1e-6) << rivals[0].name;
  }
}

TEST_F(Proxies, a_loop_that_sticks_gives_back_what_was_put_in) {
  const Rival rival = prepare_proxy(body_).front();
  rival.start(-Vec3::UnitZ());
  WorkAccount account;
  for (int k = 0; k <= 80; ++k) {
    const Vec3 at(0.001, 0.0013, 1e-4 * (std::abs(k - 40) - 20));
    account.add(at, rival.force(at));
  }
  EXPECT_NEAR(account.peak_J(), 0.5 * kStiffness_N_m * 4e-6, 1e-9);
  EXPECT_NEAR(account.work_J(), 0, 1e-9);
}

TEST_F(Proxies, a_body_too_stiff_gets_the_modulus_of_the_presses) {
  body_.depth_m = 4e-3;
  Rival stiff = prepare_proxy(body_).front();
  stiff.force = [force = stiff.force](const Vec3& tip) -> Vec3 { return 2.5 * force(tip); };
  const Rival fitted = with_fitted_modulus(stiff, body_);
  EXPECT_NEAR(press_and_slide(fitted, 0).z(), -2e-3 * kStiffness_N_m, 1e-6) << fitted.settings;
  EXPECT_NE(fitted.settings.find("modulus x 0.4,"), std::string::npos) << fitted.settings;
}

TEST(WorkAccountOf, a_spring_that_softens_on_the_way_out_creates_energy) {
  WorkAccount account;
  for (int k = 0; k <= 20; ++k) {
    const double depth = 1e-3 * (10 - std::abs(k - 10)), stiffness = k > 10 ? 300 : 200;
    account.add({0, 0, -depth}, {0, 0, -stiffness * depth});
  }
  // In against 200 N/m, out against 300; the first step back is half of either.
  EXPECT_LT(account.work_J(), -0.4 * 0.5 * 200 * 1e-4);
  EXPECT_NEAR(account.peak_J(), 0.5 * 200 * 1e-4, 1e-12);
}

// Springs of which the force of a tool that stays comes nearer to its end by a third a tick.
Rival settling_rival(const char* name, int rest_ticks) {
  Rival rival;
  rival.name = name;
  rival.rest_ticks = rest_ticks;
  rival.start = [](const Vec3&) {};
  rival.force = [off = 1.0, at = Vec3(Vec3::Zero())](const Vec3& tip) mutable -> Vec3 {
    off = at == tip ? off / 1.5 : 1;
    at = tip;
    return {0, 0, (1 + off) * kStiffness_N_m * std::min(0.0, tip.z())};
  };
  return rival;
}

TEST(Rest, ends_when_the_force_is_steady_or_its_ticks_are_over) {
  for (const int rest_ticks : {15, 60}) {
    const Rival rival = settling_rival("settling", rest_ticks);
    int ticks = 0;
    RestCount count;
    const auto tick = [&] { return ++ticks, rival.force({0, 0, -1e-3}); };
    tick();
    come_to_rest(rival, tick, count);
    EXPECT_EQ(count.rows, 1);
    EXPECT_EQ(count.rested, rest_ticks > 30);
    EXPECT_LT(ticks, 40);
    EXPECT_NEAR(tick().z(), -1e-3 * kStiffness_N_m, 0.01 * 1e-3 * kStiffness_N_m);
  }
}

struct Table {
  nlohmann::json json;
  std::string csv;
};

Table read_rivals(const std::filesystem::path& folder) {
  return {nlohmann::json::parse(read_whole_file(folder / "rivals.json")).at("plate"),
          read_whole_file(folder / "rivals.csv")};
}

std::filesystem::path fresh_folder(const char* name) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

TEST_F(Proxies, that_do_not_rest_are_left_out_by_name) {
  body_.paths = body_.samples;
  body_.depth_m = 4e-3;
  const std::filesystem::path folder = fresh_folder("rivals_rest");
  RivalsTable table(folder, "plate", "a", true);
  const auto prepare = [](const RivalBody&) -> std::vector<Rival> {
    Rival at_presses = settling_rival("no rest at presses", 40);
    at_presses.rest = {.rows = 20, .rested = 9};
    return {at_presses, settling_rival("no rest on paths", 15), settling_rival("rests", 40)};
  };
  measure_part({"explicit", "bodies that settle", prepare}, body_, 1, table);
  table.write(0.01);
  const auto [json, csv] = read_rivals(folder);
  ASSERT_EQ(json.at("rivals").size(), 1U);
  EXPECT_EQ(json.at("rivals")[0].at("rival"), "rests");
  EXPECT_NEAR(json.at("rivals")[0].at("p95_rel"), 0, 0.3);
  ASSERT_EQ(json.at("left_out").size(), 2U);
  EXPECT_EQ(json.at("left_out")[0].at("why"),
            "9 of the 20 rows of its presses came to rest in 40 ticks");
  EXPECT_EQ(json.at("left_out")[1].at("why"),
            "0 of the 10 rows of its paths came to rest in 15 ticks");
  EXPECT_EQ(csv.find("no rest"), std::string::npos);
  EXPECT_EQ(read_whole_file(folder / "rivals_plate_tick.svg").find("no rest"), std::string::npos);
}

TEST(RivalsTable, keeps_rows_of_the_parts_that_are_not_measured_again) {
  const std::filesystem::path folder = fresh_folder("rivals_parts");
  const auto measured = [](const char* name, double median) {
    Rival rival;
    rival.name = name;
    Performance did;
    did.statement.all.force.median_rel = median;
    for (std::size_t kind = 0; kind < kUprightKinds; ++kind)
      did.by_path.push_back({std::string(kPathKindNames[kind])});
    return std::pair(rival, did);
  };
  const auto add = [](RivalsTable& table, const char* part, const auto& line) {
    table.add(part, line.first, line.second);
    table.end(part, 1);
  };
  RivalsTable whole(folder, "plate", "a", true);
  add(whole, "green", measured("Green's functions", 0.2));
  add(whole, "palpate", measured("Palpate", 0.02));
  whole.leave_out("bullet", "Bullet", "its package is missing");
  whole.write(0.01);
  RivalsTable again(folder, "plate", "a", false);
  add(again, "green", measured("Green's functions", 0.1));
  again.write(0.01);
  const auto [json, csv] = read_rivals(folder);
  ASSERT_EQ(json.at("rivals").size(), 2U);
  EXPECT_EQ(json.at("rivals")[0].at("median_rel"), 0.1);
  EXPECT_EQ(json.at("rivals")[1].at("rival"), "Palpate");
  EXPECT_EQ(json.at("left_out").size(), 1U);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 3);
  EXPECT_THROW(RivalsTable(folder, "plate", "another", false), Error);
  RivalsTable(folder, "ball", "another", true).write(0.01);
  EXPECT_EQ(read_rivals(folder).csv, csv);
  RivalsTable(folder, "plate", "another", true).write(0.01);
  EXPECT_TRUE(read_rivals(folder).json.at("rivals").empty());
}

// 1 mm with a ball of 8 mm: strains are small and the simulator is near the linear body.
TEST(Green, is_our_linear_body_at_small_depth) {
  fem::SimulationSetup setup = fem::block_setup(0.3);
  const Vec3 top = fem::block_top();
  constexpr double kDepth_m = 1e-3, kRadius_m = 8e-3;
  fem::Experiments experiments = fem::press_only(1);
  experiments.depth_m = kDepth_m;
  setup.options.element_size = setup.options.growth = 0.6;
  setup.options.coarse_ratio = 1.6;
  const fem::PointRows rows =
      fem::Simulator(setup).press_and_drag(top, -Vec3::UnitZ(), experiments);
  ASSERT_EQ(rows.rows.at(0).status, RowStatus::good);
  const Points window = top.transpose();
  const auto surface =
      std::make_shared<GreenSurface>(make_green_surface(setup, window, 1.2e-3, 5e-3));
  GreenContact contact(
      surface, {.radius_m = kRadius_m, .friction = 0.3, .max_sweeps = 500, .tolerance = 1e-5});
  Vec3 force = Vec3::Zero();
  for (int k = 0; k <= 50; ++k)
    force = contact.force(top + (kRadius_m - kDepth_m * k / 50) * Vec3::UnitZ());
  EXPECT_NEAR(force.z() / rows.rows[0].force.z(), 1, 0.05) << force.transpose();
  EXPECT_LT(force.head<2>().norm(), 0.02 * force.norm());
  EXPECT_TRUE(contact.force(top + 2 * kRadius_m * Vec3::UnitZ()).isZero(1e-6));
}

TEST(Green, a_dragged_ball_is_held_by_friction_and_no_more) {
  const fem::SimulationSetup setup = fem::block_setup(0.3);
  const Vec3 top = fem::block_top();
  const Points window = top.transpose();
  const auto surface =
      std::make_shared<GreenSurface>(make_green_surface(setup, window, 2e-3, 8e-3));
  GreenContact contact(surface, {.radius_m = 8e-3, .friction = 0.3});
  const Vec3 down = top + 7e-3 * Vec3::UnitZ();
  for (int k = 0; k <= 50; ++k) contact.force(down + 1e-3 * (50 - k) / 50 * Vec3::UnitZ());
  Vec3 force = Vec3::Zero();
  for (int k = 1; k <= 100; ++k) force = contact.force(down + 2e-5 * k * Vec3::UnitX());
  EXPECT_GT(force.x(), 0.2 * -force.z());
  EXPECT_LT(force.x(), 0.5 * -force.z());  // a sunken ball ploughs, too
}

CoarseBody coarse_block(const Mat3& turn, const std::array<int, 3>& cells) {
  const TetMesh mesh = fem::structured_block({0.06, 0.06, 0.03}, cells);
  const Points turned = mesh.nodes * turn.transpose();
  CoarseBody body{turned, mesh.tets, {}, {}, {}, {}};
  for (const auto& node : mesh.nodes.rowwise()) body.is_held.push_back(node[2] < 1e-6);
  body.young_Pa = Eigen::VectorXd::Constant(mesh.tets.rows(), fem::kYoung_Pa);
  body.poisson = Eigen::VectorXd::Constant(mesh.tets.rows(), fem::kPoisson);
  const TetMesh fine = fem::structured_block({0.06, 0.06, 0.03}, {30, 30, 2});
  const Points middle = (turn * fem::block_top()).transpose();
  body.carried = carried_points(turned, mesh.tets,
                                {fine.nodes * turn.transpose(), fem::boundary_triangles(fine.tets)},
                                middle, 0.018);
  return body;
}

constexpr BallContact kBall{
    .radius_m = 8e-3, .friction = 0.3, .penalty_Pa_m = 20e3 * fem::kYoung_Pa};

// Pressed by 2 mm in steps of 40 um, then dragged along x.
template <class Body>
Vec3 press_and_drag(Body& body, const Mat3& turn, double drag_m) {
  const Vec3 above = fem::block_top() + kBall.radius_m * Vec3::UnitZ();
  Vec3 force = Vec3::Zero();
  for (int k = 0; k <= 50; ++k) force = body.force(turn * (above - 4e-5 * k * Vec3::UnitZ()));
  for (int k = 1; k <= 50; ++k)
    force = body.force(turn * (above - 2e-3 * Vec3::UnitZ() + drag_m * k / 50 * Vec3::UnitX()));
  return force;
}

// The simulator's force [N] 2 mm deep.
double simulated_press_N() {
  fem::SimulationSetup setup = fem::block_setup(0.3);
  fem::Experiments experiments = fem::press_only(1);
  experiments.depth_m = 2e-3;
  setup.options.growth = 0.6;
  setup.options.coarse_ratio = 1.6;
  const fem::PointRows rows =
      fem::Simulator(setup).press_and_drag(fem::block_top(), -Vec3::UnitZ(), experiments);
  EXPECT_EQ(rows.rows.at(0).status, RowStatus::good);
  return rows.rows.at(0).force.z();
}

// Stays where the drag of 0 mm ends.
template <class Body>
Vec3 rest_pressed(Body& body, int ticks) {
  Vec3 force = press_and_drag(body, Mat3::Identity(), 0);
  for (int k = 0; k < ticks; ++k)
    force = body.force(fem::block_top() + (kBall.radius_m - 2e-3) * Vec3::UnitZ());
  return force;
}

TEST(Corotational, comes_down_to_the_simulator_as_its_mesh_gets_finer) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {6, 12, 20}) {
    CorotationalBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}),
                          {.ball = kBall});
    const double ratio = press_and_drag(body, Mat3::Identity(), 0).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.95) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 1.4);  // linear tets lock
}

TEST(Corotational, answers_alike_however_it_is_turned) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, -0.5).normalized()).matrix();
  CorotationalBody upright(coarse_block(Mat3::Identity(), {6, 6, 3}), {.ball = kBall}),
      turned(coarse_block(turn, {6, 6, 3}), {.ball = kBall});
  const Vec3 a = press_and_drag(upright, Mat3::Identity(), 1e-3),
             b = press_and_drag(turned, turn, 1e-3);
  EXPECT_LT((turn * a - b).norm(), 1e-3 * a.norm()) << a.transpose();
  EXPECT_GT(a.x(), 0.1 * -a.z());
  EXPECT_LT(a.x(), 0.5 * -a.z());
  upright.start();
  EXPECT_TRUE(upright.force(Vec3(0.03, 0.03, 0.1)).isZero());
}

TEST(Explicit, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {6, 12, 20}) {
    ExplicitBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}), {.ball = kBall});
    const double ratio = rest_pressed(body, 400).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.95) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 1.4);  // linear tets lock
}

TEST(Explicit, six_times_the_stable_step_is_not_stable) {
  ExplicitSettings settings{.ball = kBall};
  ExplicitBody stable(coarse_block(Mat3::Identity(), {6, 6, 3}), settings);
  EXPECT_LT(rest_pressed(stable, 50).norm(), 10);
  settings.step_of_stable = 6;
  settings.tick_s = 100 * stable.stable_step_s();  // so that steps are about six times it
  ExplicitBody unstable(coarse_block(Mat3::Identity(), {6, 6, 3}), settings);
  rest_pressed(unstable, 50);
  EXPECT_FALSE(unstable.displacement().norm() < 1);
}

#if PALPATE_BULLET
TEST(Bullet, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {4, 8}) {
    BulletBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}),
                    {.ball = kBall, .density_kg_m3 = 6000});
    const double ratio = rest_pressed(body, 200).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.8) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 2.5);
}
#endif

// Where PALPATE_PACKAGES names a folder with npm's @mujoco/mujoco.
TEST(Mujoco, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const char* folder = std::getenv("PALPATE_PACKAGES");
  if (folder == nullptr) GTEST_SKIP() << "PALPATE_PACKAGES is not set";
  ASSERT_TRUE(has_mujoco(folder)) << folder;
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {6, 12}) {
    MujocoBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}), {.ball = kBall},
                    folder);
    const double ratio = rest_pressed(body, 60).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.8) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 2.5);
}

TEST(Mujoco, is_left_out_without_its_package) {
  EXPECT_FALSE(has_mujoco({}));
  EXPECT_FALSE(has_mujoco(testing::TempDir()));
  EXPECT_TRUE(prepare_mujoco({}).empty());
}

TEST(SmallNetworkOf, gradient_is_the_difference_of_its_loss) {
  SmallNetwork network(6, 5, 3, 7);
  std::srand(3);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Random(6, 9),
                        target = Eigen::MatrixXd::Random(3, 9);
  const Eigen::VectorXd weight = Eigen::VectorXd::Random(9).array().abs();
  std::vector<Eigen::MatrixXd> gradient, unused;
  network.loss(input, target, weight, gradient);
  constexpr double kStep = 1e-6;
  for (std::size_t k = 0; k < gradient.size(); ++k)
    for (Eigen::Index i = 0; i < gradient[k].size(); i += 3) {
      double& number = network.parameters()[k].data()[i];
      const double at = number;
      number = at + kStep;
      const double up = network.loss(input, target, weight, unused);
      number = at - kStep;
      const double down = network.loss(input, target, weight, unused);
      number = at;
      EXPECT_NEAR(gradient[k].data()[i], (up - down) / (2 * kStep), 1e-7) << k << ' ' << i;
    }
}

TEST_F(Proxies, a_network_learns_the_spring_of_the_samples) {
  body_.depth_m = 4e-3;
  for (const Rival& rival : prepare_neural(body_)) {
    const Vec3 force = press_and_slide(rival, 0);
    EXPECT_NEAR(force.z(), -2e-3 * kStiffness_N_m, 0.05 * 2e-3 * kStiffness_N_m) << rival.settings;
  }
}

TEST(LogFigure, has_a_mark_of_each_size_on_white_and_on_black) {
  const LogFigure figure{
      .title = "t",
      .x_label = "x",
      .y_label = "y",
      .series = {{"a", {0.1, 10}, {0.5, 0.02}, {0.9, 0.05}}, {"b", {3}, {0.1}, {0.2}}},
      .upright = {{1000, "1 kHz"}},
      .level = {{0.07, "JND"}}};
  for (const bool is_dark : {false, true}) {
    const std::string svg = draw(figure, is_dark);
    std::size_t marks = 0;
    for (std::size_t at = 0; (at = svg.find("class=\"mark\"", at)) != std::string::npos; ++at)
      ++marks;
    EXPECT_EQ(marks, 3U);
    for (const char* word : {"1 kHz", "JND", ">a<", ">b<", "100 %"})
      EXPECT_NE(svg.find(word), std::string::npos) << word;
    EXPECT_EQ(svg.find("nan"), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::tools
