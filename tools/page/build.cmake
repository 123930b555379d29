# Gets npm's packages as the lock file has them, into MODULES, and bundles the page. Where they
# cannot be had there is no page, and that is no error; a page that does not build is one.
# cmake -DNODE=... -DNPM=... -DSOURCE=... -DMODULES=... -DOUTPUT=... -DENGINE=... -P build.cmake
file(SHA256 ${SOURCE}/package-lock.json wanted)
set(stamp ${MODULES}/node_modules/.of_lock_file)
set(stored "")
if(EXISTS ${stamp})
  file(READ ${stamp} stored)
endif()
if(NOT stored STREQUAL wanted)
  file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${MODULES})
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --silent
                  WORKING_DIRECTORY ${MODULES} RESULT_VARIABLE failure)
  if(failure)
    message("palpate report: no page is built, because npm cannot get its packages (tools/page/package-lock.json)")
    return()
  endif()
  file(WRITE ${stamp} ${wanted})
endif()
execute_process(COMMAND ${NODE} ${SOURCE}/build.mjs ${SOURCE} ${MODULES} ${OUTPUT} ${ENGINE} RESULT_VARIABLE failure)
if(failure)
  message(FATAL_ERROR "the page does not build")
endif()
