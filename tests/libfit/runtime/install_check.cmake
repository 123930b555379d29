# Installs the engine alone into a clean prefix and uses it from a project of five lines, by
# find_package and by pkg-config: cmake -DSOURCE= -DWORK= -DASSET= -DVERSION= -P this
include(${CMAKE_CURRENT_LIST_DIR}/use_engine.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -DPALPATE_ENGINE_ONLY=ON
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=${WORK}/prefix -DCMAKE_INSTALL_LIBDIR=lib)
run(${CMAKE_COMMAND} --build ${WORK}/build --target install)
use_engine(${WORK}/prefix)

# The libraries are not in this prefix, and it says so.
file(WRITE ${WORK}/wanting/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(wanting C CXX)
find_package(palpate REQUIRED COMPONENTS libraries)
")
execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/wanting -B ${WORK}/wanting/build -DCMAKE_PREFIX_PATH=${WORK}/prefix
                RESULT_VARIABLE failed OUTPUT_QUIET ERROR_VARIABLE said)
if(NOT failed OR NOT said MATCHES "the component libraries is not")
  message(FATAL_ERROR "a component that is not there: ${said}")
endif()
