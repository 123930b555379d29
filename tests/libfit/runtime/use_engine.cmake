# use_engine(PREFIX): a project of five lines that uses the engine installed in PREFIX, by
# find_package and by pkg-config. Wants SOURCE, WORK, ASSET, VERSION.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

function(use_engine prefix)
  file(WRITE ${WORK}/user/CMakeLists.txt
  "cmake_minimum_required(VERSION 3.25)
project(user C CXX)
find_package(palpate ${VERSION} REQUIRED)
add_executable(c_loop ${SOURCE}/docs/embedding/loop.c)
target_link_libraries(c_loop PRIVATE palpate::engine)
add_executable(c_static ${SOURCE}/docs/embedding/loop.c)
target_link_libraries(c_static PRIVATE palpate::engine_static m)
add_executable(cpp_headers headers.cpp)
target_link_libraries(cpp_headers PRIVATE palpate::engine_headers)
target_compile_features(cpp_headers PRIVATE cxx_std_17)
")
  file(WRITE ${WORK}/user/headers.cpp
"#include <palpate/engine.hpp>
#include <cstdio>
using namespace palpate::runtime;
alignas(64) static char bytes[1 << 24];
int main(int argc, char** argv) {
  const std::size_t size = argc > 1 ? std::fread(bytes, 1, sizeof bytes, std::fopen(argv[1], \"rb\")) : 0;
  Status status;
  const Asset asset = Asset::open(bytes, size, &status);
  if (status != Status::ok) return std::puts(sentence(status)), 1;
  const auto middle = [&](int k) { return asset.origin_m[k] + 0.5 * (asset.tree[0].lo[k] + asset.tree[0].hi[k]); };
  const double top = asset.origin_m[2] + asset.tree[0].hi[2];
  Contact contact;
  Output out;
  double felt_N = 0;
  for (double z = top + 0.002; z > top - 0.02; z -= 1e-4) {
    const double tip_m[] = {middle(0) + 0.0013, middle(1) + 0.0007, z};
    if (touch(asset, contact, tip_m, out) == Status::ok && out.force_on_tool_N[2] > felt_N)
      felt_N = out.force_on_tool_N[2];
  }
  return felt_N > 0 ? 0 : 1;
}
")
  run(${CMAKE_COMMAND} -S ${WORK}/user -B ${WORK}/user/build -DCMAKE_PREFIX_PATH=${prefix})
  run(${CMAKE_COMMAND} --build ${WORK}/user/build)
  foreach(program c_loop c_static cpp_headers)
    run(${WORK}/user/build/${program} ${ASSET})
  endforeach()

  find_program(PKG_CONFIG pkg-config)
  if(PKG_CONFIG)
    execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/lib/pkgconfig
                            ${PKG_CONFIG} --cflags --libs palpate-engine
                    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags UNIX_COMMAND "${flags}")
    run(cc ${SOURCE}/docs/embedding/loop.c -o ${WORK}/by_pkg_config ${flags}
        -Wl,-rpath,${prefix}/lib)
    run(${WORK}/by_pkg_config ${ASSET})
  endif()
endfunction()

# use_libraries(PREFIX): one that fills a box with tetrahedra and fits presses that it has written.
function(use_libraries prefix)
  file(WRITE ${WORK}/libraries/CMakeLists.txt
"cmake_minimum_required(VERSION 3.25)
project(user C CXX)
find_package(palpate ${VERSION} REQUIRED COMPONENTS libraries)
add_executable(user user.cpp)
target_link_libraries(user PRIVATE palpate::fit palpate::io palpate::mesh_fill palpate::solve)
target_compile_features(user PRIVATE cxx_std_20)
")
  file(WRITE ${WORK}/libraries/user.cpp [[
#include <cmath>
#include <cstdio>
#include <limits>

#include "libfem/mesh/fill/fill_volume.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/files/files.hpp"

int main() {
  palpate::Surface box;
  box.vertices.resize(8, 3);
  for (int i = 0; i < 8; ++i) box.vertices.row(i) << (i & 1) * 0.08, (i >> 1 & 1) * 0.08, (i >> 2) * 0.03;
  box.triangles.resize(12, 3);
  box.triangles << 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  const palpate::TetMesh tets = palpate::fill_volume(box, 0.08);

  constexpr int kRows = 12;
  palpate::Samples presses;
  presses.point_position = palpate::Points::Zero(1, 3);
  presses.point_normal = palpate::Vec3(0, 0, -1).transpose();
  presses.point_name = {"p"};
  presses.deflection = presses.force = presses.torque = palpate::Points::Zero(kRows, 3);
  presses.force_error = Eigen::VectorXd::Constant(kRows, std::numeric_limits<double>::quiet_NaN());
  presses.status.assign(kRows, palpate::RowStatus::good);
  presses.kind.assign(kRows, palpate::ExperimentKind::press);
  presses.point.assign(kRows, 0);
  presses.experiment.assign(kRows, 0);
  for (int i = 0; i < kRows; ++i) {
    presses.step.push_back(i);
    presses.deflection(i, 2) = -5e-4 * (i + 1);
    presses.force(i, 2) = -2 * std::pow((i + 1.0) / kRows, 1.5);
  }
  palpate::write_samples("presses.h5", presses);
  const palpate::FittedCurves curves = palpate::fit_curves(palpate::read_samples("presses.h5"));
  std::printf("%d tetrahedra, residual %.4f N of 2\n", static_cast<int>(tets.tets.rows()), curves.rms_residual_N[0]);
  return tets.tets.rows() > 5 && curves.rms_residual_N[0] < 0.01 ? 0 : 1;
}
]])
  run(${CMAKE_COMMAND} -S ${WORK}/libraries -B ${WORK}/libraries/build -DCMAKE_PREFIX_PATH=${prefix})
  run(${CMAKE_COMMAND} --build ${WORK}/libraries/build)
  run(${CMAKE_COMMAND} -E chdir ${WORK} ${WORK}/libraries/build/user)
endfunction()
