# Makes the Debian packages of a finished build, unpacks them into a clean prefix and uses what is
# in them: cmake -DBUILD= -DSOURCE= -DWORK= -DASSET= -DVERSION= -DPYTHON= -P this. PYTHON: empty
# where the module was not built.
include(${CMAKE_CURRENT_LIST_DIR}/../libfit/runtime/use_engine.cmake)

find_program(DPKG_DEB dpkg-deb)
find_program(SHLIBDEPS dpkg-shlibdeps)
if(NOT DPKG_DEB OR NOT SHLIBDEPS)
  message("SKIPPED: there is no dpkg")
  return()
endif()

# expect(TEXT PATTERN): the text has it.
function(expect text pattern)
  if(NOT text MATCHES "${pattern}")
    message(FATAL_ERROR "no \"${pattern}\" in\n${text}")
  endif()
endfunction()
function(output variable)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(status)
    message(FATAL_ERROR "${ARGN}\n${out}${err}")
  endif()
  set(${variable} "${out}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_CPACK_COMMAND} -G DEB --config ${BUILD}/CPackConfig.cmake -B ${WORK}/packages)
file(GLOB packages ${WORK}/packages/*.deb)
list(LENGTH packages count)
set(expected 4)
if(PYTHON)
  set(expected 5)
endif()
if(NOT count EQUAL expected)
  message(FATAL_ERROR "${expected} packages were expected: ${packages}")
endif()
foreach(package ${packages})
  output(about ${DPKG_DEB} --field ${package} Package Version Depends Description)
  string(APPEND all "${about}")
  run(${DPKG_DEB} -x ${package} ${WORK}/root)
endforeach()
expect("${all}" "Package: palpate\n.*Depends: [^\n]*libhdf5")
expect("${all}" "Package: palpate\n.*Depends: [^\n]*libopenblas0")
expect("${all}" "Package: libpalpate-engine1\n")
expect("${all}" "Package: libpalpate-dev\n.*Depends: libpalpate-engine-dev")
expect("${all}" "Package: libpalpate-engine-dev\n.*Depends: libpalpate-engine1")

# The program finds its page and scenes beside it.
set(prefix ${WORK}/root/usr)
output(out ${prefix}/bin/palpate --version)
expect("${out}" "palpate ${VERSION}")
output(out ${prefix}/bin/palpate check ${prefix}/share/palpate/scenes/block.toml --no-trial --json)
expect("${out}" "\"errors\":\\[\\]")
output(out ${prefix}/bin/palpate bench --help)
expect("${out}" "CalculiX")

# Completion and manual say what the program itself says.
foreach(file share/man/man1/palpate.1 share/man/man1/palpate-fit.1
        share/zsh/vendor-completions/_palpate share/fish/vendor_completions.d/palpate.fish)
  file(READ ${prefix}/${file} text)
  expect("${text}" "fit")
endforeach()
expect("${text}" "-l family -r")
find_program(BASH bash REQUIRED)
function(complete words count wanted)
  output(out ${BASH} -c
         "source ${prefix}/share/bash-completion/completions/palpate && COMP_WORDS=(${words}) && \
          COMP_CWORD=${count} && _palpate && echo \"\${COMPREPLY[@]}\"")
  expect("${out}" "^${wanted}\n")
endfunction()
complete("palpate rep" 1 "report replay")
complete("palpate fit --fam" 2 "--family")
complete("palpate export --json --" 3 "--help [^\n]*--elsewhere[^\n]*")
find_program(GROFF groff)
if(GROFF)
  file(GLOB pages ${prefix}/share/man/man1/*.1)
  foreach(page ${pages})
    execute_process(COMMAND ${GROFF} -man -Tascii -ww ${page} OUTPUT_QUIET ERROR_VARIABLE warnings)
    if(warnings)
      message(FATAL_ERROR "${page}: ${warnings}")
    endif()
  endforeach()
endif()
foreach(shell zsh fish)
  find_program(SHELL_${shell} ${shell})
endforeach()
if(SHELL_zsh)
  run(${SHELL_zsh} -n ${prefix}/share/zsh/vendor-completions/_palpate)
endif()
if(SHELL_fish)
  run(${SHELL_fish} --no-execute ${prefix}/share/fish/vendor_completions.d/palpate.fish)
endif()

use_engine(${prefix})
use_libraries(${prefix})

# Five lines of Python, with what the package and what the wheel holds.
if(PYTHON)
  expect("${all}" "Package: python3-palpate\n.*Depends: [^\n]*python3-numpy")
  file(WRITE ${WORK}/user.py
"import palpate, sys
with palpate.open(sys.argv[1]) as asset:
    above = asset.box_m[1] + 0.001
    ticks = asset.contact().tick([above, above])
print(palpate.__file__, palpate.sentence(ticks['status'][1]))
")
  function(use_python folder)
    output(out ${CMAKE_COMMAND} -E env PYTHONPATH=${folder} ${PYTHON} ${WORK}/user.py ${ASSET})
    expect("${out}" "^${folder}/palpate/")
  endfunction()
  use_python(${prefix}/lib/python3/dist-packages)
  output(out ${CMAKE_COMMAND} -E env PYTHONPATH=${prefix}/lib/python3/dist-packages --unset=PALPATE_PROGRAM
         ${PYTHON} -c "print(__import__('palpate.program').program.program())")
  expect("${out}" "^${prefix}/bin/palpate\n")

  # A virtual environment finds what is installed into it.
  execute_process(COMMAND ${PYTHON} -m venv --without-pip --system-site-packages ${WORK}/venv
                  RESULT_VARIABLE no_venv OUTPUT_QUIET ERROR_QUIET)
  if(NOT no_venv)
    run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/venv --component python)
    run(${WORK}/venv/bin/python3 ${WORK}/user.py ${ASSET})
  endif()

  execute_process(COMMAND ${PYTHON} -c "import setuptools, wheel" RESULT_VARIABLE no_wheel ERROR_QUIET)
  if(NOT no_wheel)
    run(${CMAKE_COMMAND} --build ${BUILD} --target palpate_wheel)
    file(GLOB wheel ${BUILD}/tools/python/wheel/palpate-${VERSION}-*.whl)
    file(ARCHIVE_EXTRACT INPUT ${wheel} DESTINATION ${WORK}/wheel)
    use_python(${WORK}/wheel)
  endif()
endif()
