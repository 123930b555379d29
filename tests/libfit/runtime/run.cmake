# run(COMMAND ...): ends the script with what the command printed where it fails; RUN_OUTPUT.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE failed OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(failed)
    message(FATAL_ERROR "${ARGV}\n${text}")
  endif()
  set(RUN_OUTPUT "${text}" PARENT_SCOPE)
endfunction()
