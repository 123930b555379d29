# The engine by another compiler, for another machine: cmake -DCHECK=windows|arm -DSOURCE= -DWORK=
# -DASSETS= -P this. loop.c opens the asset, and opening replays its check path bit for bit.
set(engine ${SOURCE}/libfit/runtime)
set(flags -O2 -ffp-contract=off -Wall -Wextra -Werror)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
# compiler(NAME): ${NAME}g++ and ${NAME}gcc, or this test is skipped.
macro(compiler prefix)
  find_program(CXX ${prefix}g++)
  find_program(C ${prefix}gcc)
  if(NOT CXX OR NOT C)
    message("SKIPPED: there is no ${prefix}g++")
    return()
  endif()
endmacro()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

if(CHECK STREQUAL windows)
  compiler(x86_64-w64-mingw32-)
  run(${CXX} -std=c++17 ${flags} -fno-exceptions -fno-rtti -DPALPATE_EXPORTS -shared
      ${engine}/palpate.cpp -o ${WORK}/palpate_engine.dll -static
      -Wl,--out-implib,${WORK}/libpalpate_engine.dll.a)
  run(${C} -std=c99 ${flags} -DPALPATE_DLL -I${engine} -c
      ${SOURCE}/tests/libfit/runtime/c_walk.c -o ${WORK}/c_walk.o)
  # Every function of the header is exported, and nothing else.
  find_program(OBJDUMP x86_64-w64-mingw32-objdump REQUIRED)
  execute_process(COMMAND ${OBJDUMP} -p ${WORK}/palpate_engine.dll OUTPUT_VARIABLE dump)
  string(REGEX REPLACE ".*\\[Ordinal/Name Pointer\\] Table" "" dump "${dump}")
  string(FIND "${dump}" "\n\n" end)
  string(SUBSTRING "${dump}" 0 ${end} dump)
  file(READ ${engine}/palpate.h header)
  string(REGEX MATCHALL "PALPATE_API [a-z][a-z0-9_ *]+\\(" declared "${header}")
  list(LENGTH declared count)
  if(count LESS 10)
    message(FATAL_ERROR "${count} functions of the header were found")
  endif()
  foreach(function ${declared})
    string(REGEX REPLACE ".*[ *](palpate_[a-z_]+)\\($" "\\1" name "${function}")
    if(NOT "${dump}\n" MATCHES "\\] ${name}\n")
      message(FATAL_ERROR "${name} is not exported:\n${dump}")
    endif()
  endforeach()
  string(REGEX MATCHALL "\\] [A-Za-z_]+" exported "${dump}")
  foreach(line ${exported})
    if(NOT line MATCHES "\\] palpate_")
      message(FATAL_ERROR "exported beside the header's: ${line}")
    endif()
  endforeach()
  find_program(RUNNER wine)
  set(program ${WORK}/open.exe)
elseif(CHECK STREQUAL arm)
  compiler(aarch64-linux-gnu-)
  find_program(RUNNER qemu-aarch64)
  set(program ${WORK}/open)
endif()

# A program of standard C alone: loop.c maps files by POSIX.
file(WRITE ${WORK}/open.c "
#include <stdio.h>
#include <stdlib.h>
#include \"palpate.h\"
int main(int argc, char** argv) {
  FILE* file = argc > 1 ? fopen(argv[1], \"rb\") : NULL;
  static unsigned char room[1 << 24], bytes[1 << 24];
  palpate_asset asset;
  size_t size = file ? fread(bytes, 1, sizeof bytes, file) : 0;
  palpate_status status =
      palpate_open(&asset, palpate_copy_aligned(room, sizeof room, bytes, size), size);
  puts(palpate_sentence(status));
  return (int)status;
}
")
run(${CXX} -std=c++17 ${flags} -fno-exceptions -fno-rtti -DPALPATE_STATIC -c ${engine}/palpate.cpp
    -o ${WORK}/palpate.o)
run(${C} -std=c99 ${flags} -DPALPATE_STATIC -I${engine} -c ${WORK}/open.c -o ${WORK}/open.o)
run(${C} -static ${WORK}/open.o ${WORK}/palpate.o -lm -o ${program})
if(NOT RUNNER AND CHECK STREQUAL windows)
  message("it compiles and exports what it should; there is no wine to run it")
  return()
elseif(NOT RUNNER)
  message("SKIPPED: it compiles; there is no qemu-aarch64 to run it")
  return()
endif()
foreach(asset ${ASSETS})
  run(${RUNNER} ${program} ${asset})
endforeach()
