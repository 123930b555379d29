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
