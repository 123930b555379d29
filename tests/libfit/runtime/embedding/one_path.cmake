# One path of a ball and a turning capsule, ticked together, has the same bits from everyone: C writes
# it (walk_bits), and `palpate replay`, Python and the page's WebAssembly repeat it; C# does so in
# unity_check.cmake.
# cmake -DSOURCE= -DWORK= -DWALK= -DCOUPLED= -DRADIUS= -DPROGRAM= -DPYTHON= -DMODULE= -DPAGE= -P this
# PYTHON with the folder MODULE of its package, and PAGE, the folder of engine.wasm and npm's packages,
# may be empty: what is not there is named.
include(${CMAKE_CURRENT_LIST_DIR}/../run.cmake)
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND ${WALK} ${COUPLED} 4000 two OUTPUT_FILE ${WORK}/two.csv COMMAND_ERROR_IS_FATAL ANY)
set(missing "")
if(PYTHON)
  run(${CMAKE_COMMAND} -E env PYTHONPATH=${MODULE} ${PYTHON} -B ${SOURCE}/tests/tools/python/one_path.py ${COUPLED}
      ${WORK}/two.csv ${PROGRAM})
else()
  list(APPEND missing "Python, which also compares replay")
endif()
find_program(NODE node)
if(NODE AND EXISTS "${PAGE}/engine.wasm" AND EXISTS "${PAGE}/node_modules/.of_lock_file")
  run(${NODE} ${SOURCE}/tests/tools/page/two_tools.mjs ${PAGE} ${COUPLED} ${WORK}/two.csv ${RADIUS})
else()
  list(APPEND missing "the page's engine, or npm's packages")
endif()
if(missing)
  message("SKIPPED: not here: ${missing}")
endif()
