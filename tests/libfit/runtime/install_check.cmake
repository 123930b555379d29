# Installs the engine alone into a clean prefix and uses it from a project of five lines, by
# find_package and by pkg-config: cmake -DSOURCE= -DWORK= -DASSET= -DVERSION= -P this
include(${CMAKE_CURRENT_LIST_DIR}/use_engine.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -DPALPATE_ENGINE_ONLY=ON
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=${WORK}/prefix -DCMAKE_INSTALL_LIBDIR=lib)
run(${CMAKE_COMMAND} --build ${WORK}/build --target install)
use_engine(${WORK}/prefix)
