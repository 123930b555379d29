# The C lines of README.md as they stand there: what precedes "palpate_input in" runs once, the rest
# at every tick of a press, on an asset that fread put where malloc said. Wants README, ENGINE, WORK,
# ASSETS.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
find_program(CC NAMES cc gcc REQUIRED)
find_program(CXX NAMES c++ g++ REQUIRED)
file(READ ${README} text)
string(REGEX MATCH "```c\n(#include [^\n]*)\n(.*)\n(palpate_input in = [^`]*)```" _ "${text}")
if(NOT CMAKE_MATCH_3)
  message(FATAL_ERROR "${README} has no C lines that end with a tick")
endif()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
file(CREATE_LINK ${ENGINE} ${WORK}/engine SYMBOLIC)
file(WRITE ${WORK}/lines.c "${CMAKE_MATCH_1}
#include <stdio.h>
#include <stdlib.h>
int main(int argc, char** argv) {
  FILE* file = argc == 2 ? fopen(argv[1], \"rb\") : NULL;
  const size_t room = 1 << 24;
  void* bytes = malloc(room);
  const size_t size = file ? fread(bytes, 1, room, file) : 0;
  double most_N = 0;
${CMAKE_MATCH_2}
  palpate_info info;
  palpate_describe(&asset, &info);
  for (int tick = 0; tick < 300; ++tick) {
    const double x_m = 0.5 * (info.box_min_m[0] + info.box_max_m[0]) + 0.0013;
    const double y_m = 0.5 * (info.box_min_m[1] + info.box_max_m[1]) + 0.0007;
    const double z_m = info.box_max_m[2] + 0.001 - 2e-5 * tick;
${CMAKE_MATCH_3}
    if (out.force_on_tool_N[2] > most_N) most_N = out.force_on_tool_N[2];
  }
  printf(\"%g N\\n\", most_N);
  return most_N > 0.01 ? 0 : 3;
}
")
run(${CXX} -std=c++17 -O1 -ffp-contract=off -c ${ENGINE}/palpate.cpp -o ${WORK}/palpate.o)
run(${CC} -std=c99 -Wall -Wextra -Werror -I${WORK} ${WORK}/lines.c ${WORK}/palpate.o -lm -o ${WORK}/lines)
foreach(asset ${ASSETS})
  run(${WORK}/lines ${asset})
  message("${asset}: ${RUN_OUTPUT}")
endforeach()
