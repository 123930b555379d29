#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/fem.hpp"

namespace palpate::tools {
namespace {

constexpr double kYoung_Pa = 10e3, kPoisson = 0.45, kRadius_m = 0.01, kDepth_m = 0.01;
constexpr int kRows = 10;
constexpr double kMillimetres = 1e3;
constexpr double kMaxTime_s = 900;  // of the other program, wall

/// A deck says: mm, N, MPa. The ball is a thin cap of wedges, all nodes driven.
struct BallCap {
  std::vector<Vec3> nodes_m;  // outer ones first, then as many inner ones
  std::vector<std::array<int, 3>> triangles;
};

/// Rings around the lowest point of a ball that rests on `touch` from above, to 80 degrees.
BallCap ball_cap(const Vec3& touch) {
  constexpr int kRings = 32, kAround = 64;
  BallCap cap;
  const Vec3 middle = touch + kRadius_m * Vec3::UnitZ();
  const auto at = [&](double radius_m, double polar, double around) {
    return Vec3(middle + radius_m * Vec3(std::sin(polar) * std::cos(around),
                                         std::sin(polar) * std::sin(around), -std::cos(polar)));
  };
  for (const double radius_m : {kRadius_m, 0.8 * kRadius_m}) {
    cap.nodes_m.push_back(at(radius_m, 0, 0));
    for (int ring = 1; ring <= kRings; ++ring)
      for (int k = 0; k < kAround; ++k)
        cap.nodes_m.push_back(at(radius_m, ring * 80.0 / kRings * std::numbers::pi / 180,
                                 2 * std::numbers::pi * k / kAround));
  }
  const auto node = [](int ring, int k) {
    return ring == 0 ? 0 : 1 + (ring - 1) * kAround + k % kAround;
  };
  for (int ring = 0; ring < kRings; ++ring)
    for (int k = 0; k < kAround; ++k) {
      if (ring > 0) cap.triangles.push_back({node(ring, k), node(ring, k + 1), node(ring + 1, k)});
      cap.triangles.push_back({node(ring, k + 1), node(ring + 1, k + 1), node(ring + 1, k)});
    }
  return cap;
}

/// The graded mesh that a press of these options is made on.
fem::QuadraticMesh mesh_of(const FemCase& what) {
  const fem::SolverOptions& options = what.setup.options;
  const fem::Probe probe = fem::make_probe(what.setup.probe, "bench");
  const double depth_m = options.shallowest * kDepth_m;
  fem::GradeOptions grade;
  grade.growth = options.growth;
  grade.path = {{what.place, what.place, options.element_size * probe.mesh_length_m(depth_m),
                 probe.contact_reach_m(depth_m) - probe.mesh_length_m(depth_m)}};
  return fem::grade_mesh(what.setup.volume, what.setup.is_held,
                         fem::SmoothSurface(what.setup.surface), grade);
}

/// The press as a deck of CalculiX: ten-node tets, W = C10 (I1 J^-2/3 - 3) + (J - 1)^2 / D1,
/// contact face to face with a linear penalty. Node and element numbers from 1.
std::string calculix_deck(const fem::QuadraticMesh& mesh, const Vec3& touch) {
  // Faces of a tet as CalculiX counts them, by their corners.
  static constexpr int kFace[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};
  const double mu = kYoung_Pa / (2 * (1 + kPoisson)) * 1e-6;
  const double bulk = kYoung_Pa / (3 * (1 - 2 * kPoisson)) * 1e-6;
  const long nodes = mesh.nodes.rows(), tets = mesh.tets.rows();
  const BallCap cap = ball_cap(touch);
  const long ball = static_cast<long>(cap.nodes_m.size()), outer = ball / 2;
  std::string deck = "*NODE, NSET=NALL\n";
  const auto place = [&](long number, const Vec3& x) {
    deck += fmt::format("{}, {:.9g}, {:.9g}, {:.9g}\n", number, kMillimetres * x[0],
                        kMillimetres * x[1], kMillimetres * x[2]);
  };
  for (long n = 0; n < nodes; ++n) place(n + 1, mesh.nodes.row(n));
  deck += "*NODE, NSET=NBALL\n";
  for (long n = 0; n < ball; ++n) place(nodes + n + 1, cap.nodes_m[static_cast<std::size_t>(n)]);
  deck += "*ELEMENT, TYPE=C3D10, ELSET=BODY\n";
  for (long t = 0; t < tets; ++t) {
    deck += fmt::format("{}", t + 1);
    for (int a = 0; a < 10; ++a) deck += fmt::format(", {}", mesh.tets(t, a) + 1);
    deck += "\n";
  }
  deck += "*ELEMENT, TYPE=C3D6, ELSET=BALL\n";
  for (std::size_t k = 0; k < cap.triangles.size(); ++k) {
    const auto& [a, c, b] = cap.triangles[k];  // wedges from the outside in
    deck += fmt::format("{}, {}, {}, {}, {}, {}, {}\n", tets + 1 + static_cast<long>(k),
                        nodes + 1 + a, nodes + 1 + b, nodes + 1 + c, nodes + 1 + outer + a,
                        nodes + 1 + outer + b, nodes + 1 + outer + c);
  }
  deck += "*NSET, NSET=HELD\n";
  for (long n = 0; n < nodes; ++n)
    if (mesh.is_held[static_cast<std::size_t>(n)]) deck += fmt::format("{},\n", n + 1);
  deck += "*SURFACE, NAME=SKIN, TYPE=ELEMENT\n";
  const double top_m = touch.z();
  for (long t = 0; t < tets; ++t)
    for (int f = 0; f < 4; ++f) {
      bool is_near = true;
      for (const int corner : kFace[f]) {
        const Vec3 x = mesh.nodes.row(mesh.tets(t, corner));
        is_near &= x.z() > top_m - 1e-6 && (x - touch).norm() < 2.5 * kRadius_m;
      }
      if (is_near) deck += fmt::format("{}, S{}\n", t + 1, f + 1);
    }
  deck += "*SURFACE, NAME=TOOL, TYPE=ELEMENT\n";
  for (std::size_t k = 0; k < cap.triangles.size(); ++k)
    deck += fmt::format("{}, S1\n", tets + 1 + static_cast<long>(k));
  deck += fmt::format(
      "*MATERIAL, NAME=GEL\n*HYPERELASTIC, NEO HOOKE\n{:.9g}, {:.9g}\n"
      "*SOLID SECTION, ELSET=BODY, MATERIAL=GEL\n"
      "*MATERIAL, NAME=STEEL\n*ELASTIC\n1., 0.3\n"
      "*SOLID SECTION, ELSET=BALL, MATERIAL=STEEL\n",
      mu / 2, 2 / bulk);
  // 50 E per millimetre: half a percent of the force is lost to it.
  deck += fmt::format(
      "*SURFACE INTERACTION, NAME=TOUCH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
      "{:.6g}, 1e-8\n*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE\nSKIN, TOOL\n",
      50 * kYoung_Pa * 1e-6);
  deck += fmt::format(
      "*BOUNDARY\nHELD, 1, 3\n*STEP, NLGEOM, INC=400\n*STATIC\n{0}, 1., 1e-4, {0}\n*BOUNDARY\n"
      "NBALL, 1, 2, 0.\nNBALL, 3, 3, {1:.9g}\n"
      "*NODE PRINT, NSET=HELD, TOTALS=ONLY\nRF\n*END STEP\n",
      1.0 / kRows, -kMillimetres * kDepth_m);
  return deck;
}

double children_cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Vertical reactions of the held nodes [N] by time, as `*NODE PRINT, TOTALS=ONLY` writes them.
std::vector<std::pair<double, double>> read_reactions(const std::filesystem::path& path) {
  std::vector<std::pair<double, double>> out;
  std::ifstream file(path);
  double time = 0;
  bool is_next = false;
  for (std::string line; std::getline(file, line);) {
    if (const auto at = line.find("and time"); at != std::string::npos) {
      time = std::atof(line.c_str() + at + 8);
      is_next = true;
      continue;
    }
    double x = 0, y = 0, z = 0;
    if (is_next && std::sscanf(line.c_str(), "%lf %lf %lf", &x, &y, &z) == 3) {
      out.emplace_back(time, z);
      is_next = false;
    }
  }
  return out;
}

}  // namespace

void bench_peers(const BenchRequest& request) {
  FemCase what = fem_block(kPoisson);
  what.setup.materials = {{"neo-hookean-isochoric", {kYoung_Pa, kPoisson}}};
  what.setup.options.coarse_ratio = 0;
  what.setup.options.element_size = request.is_quick ? 1.2 : 1.0;
  what.setup.options.growth = 1;
  FemCase finest = what;
  finest.setup.options.element_size = finest.setup.options.growth = 0.45;
  finest.setup.options.coarse_ratio = 1.6;
  const fem::QuadraticMesh mesh = mesh_of(what);
  const FemRun ours = run_case(what, press_of(kDepth_m, kRows)),
               truth = run_case(finest, press_of(kDepth_m, kRows));
  const auto folder = std::filesystem::temp_directory_path() / "palpate-peers";
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / "press.inp", calculix_deck(mesh, what.place));
  say("wrote {} ({} nodes of the body, {} tets)", (folder / "press.inp").string(),
      mesh.nodes.rows(), mesh.tets.rows());

  std::vector<std::pair<double, double>> reactions;
  double peer_s = 0;
  if (std::system("command -v ccx > /dev/null 2>&1") != 0) {
    say("ccx is not installed (Debian: calculix-ccx); the deck alone is written");
  } else {
    const double before_s = children_cpu_s();
    const std::string command = fmt::format(
        "cd '{}' && OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 timeout {} ccx press > press.log 2>&1",
        folder.string(), kMaxTime_s);
    const int status = std::system(command.c_str());
    peer_s = children_cpu_s() - before_s;
    reactions = read_reactions(folder / "press.dat");
    if (status != 0)
      say("ccx ended with status {}; see {}", status, (folder / "press.log").string());
  }

  BenchTable table{{"depth_mm", "ours_N", "calculix_N", "reference_N", "ours_error_percent",
                    "calculix_error_percent", "ours_CPU_s", "calculix_CPU_s", "ratio", "nodes"},
                   {}};
  for (std::size_t k = 0; k < kRows; ++k) {
    const double time = static_cast<double>(k + 1) / kRows;
    const auto found = std::find_if(reactions.begin(), reactions.end(), [&](const auto& row) {
      return std::abs(row.first - time) < 1e-4;
    });
    const auto force = [&](const FemRun& run) { return run.rows.force.row(k).norm(); };
    const double reference = force(truth);
    const auto percent = [&](double f) {
      return fmt::format("{:+.2f}", 100 * (f / reference - 1));
    };
    const bool has_peer = found != reactions.end();
    table.rows.push_back(
        {fmt::format("{:.0f}", 1e3 * kDepth_m * time), fmt::format("{:.5f}", force(ours)),
         has_peer ? fmt::format("{:.5f}", std::abs(found->second)) : "-",
         fmt::format("{:.5f}", reference), percent(force(ours)),
         has_peer ? percent(std::abs(found->second)) : "-", fmt::format("{:.2f}", ours.cpu_s),
         peer_s > 0 ? fmt::format("{:.1f}", peer_s) : "-",
         peer_s > 0 ? fmt::format("{:.0f}", peer_s / ours.cpu_s) : "-",
         fmt::format("{}", mesh.nodes.rows())});
  }
  show_table(table, "peers", request);
}

}  // namespace palpate::tools
