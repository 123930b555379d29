# Debian packages: `cpack -G DEB` in a finished build folder writes palpate (the program, its page,
# man pages, completion, scenes), libpalpate-engineN (the C library), libpalpate-engine-dev,
# libpalpate-dev (the libraries it is made of, static) and, where it was built, python3-palpate.
get_target_property(abi palpate_engine_shared SOVERSION)
set(CPACK_PACKAGE_NAME palpate)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGE_CONTACT "Palpate contributors <palpate@invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program engine engine-dev libraries)
if(TARGET palpate_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next_python "${PALPATE_PYTHON_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-palpate)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.${PALPATE_PYTHON_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "palpate, python3-h5py, python3-matplotlib")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION
      "Palpate's engine over NumPy arrays, its files as arrays, and its commands as functions")
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME palpate)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ENGINE_PACKAGE_NAME libpalpate-engine${abi})
set(CPACK_DEBIAN_ENGINE_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_ENGINE-DEV_PACKAGE_NAME libpalpate-engine-dev)
set(CPACK_DEBIAN_ENGINE-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_ENGINE-DEV_PACKAGE_DEPENDS "libpalpate-engine${abi} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_NAME libpalpate-dev)
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_SHLIBDEPS OFF)
string(CONCAT CPACK_DEBIAN_LIBRARIES_PACKAGE_DEPENDS "libpalpate-engine-dev (= ${PROJECT_VERSION}), "
  "libceres-dev, libeigen3-dev, libfmt-dev, libtbb-dev, nlohmann-json3-dev, zlib1g-dev, libzip-dev, libhdf5-dev, "
  "libcgal-dev, libopenmesh-dev, libtet1.5-dev, libsuitesparse-dev, libopenblas-dev, libxxhash-dev")
set(CPACK_COMPONENT_LIBRARIES_DESCRIPTION
    "Static libraries and headers that Palpate's program is made of: fitting, files, FEM (C++20)")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "Turns a soft body, simulated or measured, into a haptic asset with a statement of its error")
set(CPACK_COMPONENT_ENGINE_DESCRIPTION "Replays Palpate's assets in a haptic loop: the C library")
set(CPACK_COMPONENT_ENGINE-DEV_DESCRIPTION
    "Headers, CMake package and pkg-config file of Palpate's engine (C and C++)")
include(CPack)

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/palpate COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/libfit/runtime/LICENSE DESTINATION share/doc/libpalpate-engine${abi}
        COMPONENT engine)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/scenes ${PROJECT_SOURCE_DIR}/data/bodies
        DESTINATION share/palpate COMPONENT program)
