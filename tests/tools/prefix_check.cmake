# Installs the program into a folder, as on a disk that a cluster's nodes share, and lets it plan a
# study, whose tasks must start that very program: cmake -DBUILD= -DSOURCE= -DWORK= -P this.
file(REMOVE_RECURSE ${WORK})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(status)
    message(FATAL_ERROR "${ARGN}\n${out}${err}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --component program)
file(WRITE ${WORK}/study.toml
  "scene = \"${SOURCE}/data/scenes/liver.toml\"\n[vary]\n\"material.young\" = [\"3 kPa\", \"6 kPa\"]\n")
run(env -i PATH=/usr/bin:/bin ${WORK}/prefix/bin/palpate study ${WORK}/study.toml -o ${WORK}/out --on script)
if(NOT out MATCHES "'${WORK}/prefix/bin/palpate' study task '${WORK}/out'")
  message(FATAL_ERROR "tasks start another program:\n${out}")
endif()
