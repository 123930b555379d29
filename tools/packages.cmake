# Debian packages: `cpack -G DEB` in a finished build folder writes palpate (the program, its page,
# scenes, documents), libpalpate-engineN (the C library), libpalpate-engine-dev,
# libpalpate-dev (the libraries it is made of, static) and, where it was built, python3-palpate.
get_target_property(abi palpate_engine_shared SOVERSION)
set(CPACK_PACKAGE_NAME palpate)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_CONTACT "Palpate contributors")
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
      "Palpate's haptic engine, files and commands in Python\n\
The engine runs over NumPy arrays, files are read as arrays, and commands are functions.")
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
  "libceres-dev, libeigen3-dev, libfmt-dev, libtbb-dev, nlohmann-json3-dev, zlib1g-dev, libhdf5-dev, "
  "libcgal-dev, libopenmesh-dev, libtet1.5-dev, libsuitesparse-dev, liblapack-dev, libsleef-dev, libxxhash-dev")
set(CPACK_COMPONENT_LIBRARIES_DESCRIPTION
    "libraries that Palpate's program is made of\n\
Static libraries and headers in C++20: fitting, files, finite elements, calibration.")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "turns a soft body into forces for a 1 kHz haptic loop\n\
The program makes an asset of a mesh and a material, or of recordings of a rig, and states its\n\
error. With its page, manual, scenes and documents.")
set(CPACK_COMPONENT_ENGINE_DESCRIPTION
    "replays Palpate's assets in a haptic loop\n\
The C library. It needs no other, allocates nothing in a tick, and is MIT-licensed.")
set(CPACK_COMPONENT_ENGINE-DEV_DESCRIPTION
    "headers of Palpate's haptic engine, for C and C++\n\
With a CMake package and a pkg-config file.")
include(CPack)

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/palpate COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/libfit/runtime/LICENSE DESTINATION share/doc/libpalpate-engine${abi}
        COMPONENT engine)
# Messages and help name pages of docs/.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION share/doc/palpate COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION share/doc/palpate COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/scenes ${PROJECT_SOURCE_DIR}/data/bodies
        DESTINATION share/palpate COMPONENT program)
