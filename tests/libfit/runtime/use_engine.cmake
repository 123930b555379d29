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
int main() { return palpate::runtime::Contact{}.has_tip ? 1 : 0; }
")
  run(${CMAKE_COMMAND} -S ${WORK}/user -B ${WORK}/user/build -DCMAKE_PREFIX_PATH=${prefix})
  run(${CMAKE_COMMAND} --build ${WORK}/user/build)
  foreach(program c_loop c_static)
    run(${WORK}/user/build/${program} ${ASSET})
  endforeach()
  run(${WORK}/user/build/cpp_headers)

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
