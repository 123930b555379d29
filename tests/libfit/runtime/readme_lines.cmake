# README.md's lines of C and C++, built by its own command lines: what precedes "palpate_input in" and
# "status = touch" runs once, the rest at every tick of a press, on an asset that fread put where
# malloc said. The same press by docs/embedding/wasm.mjs where
# clang makes WebAssembly. Wants README, EMBEDDING, ENGINE, WORK, ASSETS.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(READ ${README} text)
string(REGEX MATCH "```c\n(#include [^\n]*)\n(.*)\n(palpate_input in = [^`]*)```" _ "${text}")
set(c_include "${CMAKE_MATCH_1}")
set(c_once "${CMAKE_MATCH_2}")
set(c_tick "${CMAKE_MATCH_3}")
string(REGEX MATCH "```cpp\n(.*)(Contact contact;.*)(status = touch[^`]*)```" _ "${text}")
set(cpp_include "${CMAKE_MATCH_1}")
set(cpp_once "${CMAKE_MATCH_2}")
set(cpp_tick "${CMAKE_MATCH_3}")
string(REGEX MATCH "```sh\n(g[^`]*)```" _ "${text}")
set(build "${CMAKE_MATCH_1}")
if(NOT c_tick OR NOT cpp_tick OR NOT build)
  message(FATAL_ERROR "${README} lacks lines of C, of C++ or of the compiler")
endif()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
file(CREATE_LINK ${ENGINE} ${WORK}/engine SYMBOLIC)
# A program around the lines: its includes, what runs once, and a press from above the box.
function(write_program name includes once box_low box_high tick)
  file(WRITE ${WORK}/${name} "${includes}
#include <stdio.h>
#include <stdlib.h>
int main(int argc, char** argv) {
  FILE* file = argc == 2 ? fopen(argv[1], \"rb\") : NULL;
  const size_t room = 1 << 24;
  void* bytes = malloc(room);
  const size_t size = file ? fread(bytes, 1, room, file) : 0;
  double most_N = 0;
${once}
  for (int i = 0; i < 300; ++i) {
    const double x_m = 0.5 * (${box_low}[0] + ${box_high}[0]) + 0.0013;
    const double y_m = 0.5 * (${box_low}[1] + ${box_high}[1]) + 0.0007;
    const double z_m = ${box_high}[2] + 0.001 - 2e-5 * i;
${tick}
    if (out.force_on_tool_N[2] > most_N) most_N = out.force_on_tool_N[2];
  }
  printf(\"%g N\\n\", most_N);
  return most_N > 0.01 ? 0 : 3;
}
")
endfunction()
write_program(yours.c "${c_include}" "${c_once}
  palpate_info info;
  palpate_describe(&asset, &info);" info.box_min_m info.box_max_m "${c_tick}")
write_program(yours.cpp "${cpp_include}" "${cpp_once}
  if (status != Status::ok) return 2;
  double low_m[3], high_m[3];
  for (int k = 0; k < 3; ++k) {
    low_m[k] = asset.origin_m[k] + asset.tree[0].lo[k];
    high_m[k] = asset.origin_m[k] + asset.tree[0].hi[k];
  }" low_m high_m "
    const double tip_m[3] = {x_m, y_m, z_m};
${cpp_tick}
    if (status != Status::ok) return 2;")
file(WRITE ${WORK}/build.sh "set -e\n${build}")
run(${CMAKE_COMMAND} -E chdir ${WORK} bash build.sh)
run(${CMAKE_COMMAND} -E chdir ${WORK} g++ -std=c++17 -Wall -Wextra -Werror -ffp-contract=off yours.cpp -o yours_cpp)
find_program(CLANGXX NAMES clang++ clang++-14)
find_program(NODE node)
if(CLANGXX AND NODE)
  file(READ ${EMBEDDING}/wasm.cpp wasm)
  string(REGEX MATCH "//   (clang[^\n]*)\n//     ([^\n]*)" _ "${wasm}")
  file(COPY ${EMBEDDING}/wasm.cpp DESTINATION ${WORK})
  file(WRITE ${WORK}/wasm.sh "${CMAKE_MATCH_1} ${CMAKE_MATCH_2}")
  execute_process(COMMAND bash wasm.sh WORKING_DIRECTORY ${WORK} RESULT_VARIABLE no_wasm ERROR_VARIABLE why)
  message("WebAssembly: ${no_wasm} ${why}")  # without wasi-libc clang makes none
endif()
foreach(asset ${ASSETS})
  run(${WORK}/yours ${asset})
  set(of_c "${RUN_OUTPUT}")
  run(${WORK}/yours_cpp ${asset})
  message("${asset}: ${RUN_OUTPUT}")
  if(NOT RUN_OUTPUT STREQUAL of_c)
    message(FATAL_ERROR "the C lines find ${of_c}")
  endif()
  if(EXISTS ${WORK}/palpate.wasm)
    run(${NODE} ${EMBEDDING}/wasm.mjs ${WORK}/palpate.wasm ${asset})
    if(NOT RUN_OUTPUT STREQUAL of_c)
      message(FATAL_ERROR "WebAssembly finds ${RUN_OUTPUT}")
    endif()
  endif()
endforeach()
