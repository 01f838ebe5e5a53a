# SPDX-License-Identifier: BSD-3-Clause
# Finds LCM and its generator. Debian ships no CMake package for LCM 1.3, and its pkg-config file asks for glib's
# headers, which nobody who links LCM needs.
#
# Defines the target LCM::LCM and the variable LCM_GEN_EXECUTABLE.
find_path(LCM_INCLUDE_DIR lcm/lcm-cpp.hpp)
find_library(LCM_LIBRARY lcm)
find_program(LCM_GEN_EXECUTABLE lcm-gen)
find_file(LCM_PC lcm.pc PATHS ${CMAKE_LIBRARY_PATH} /usr/lib /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE} /usr/local/lib
          PATH_SUFFIXES pkgconfig)
if(LCM_PC)
  file(STRINGS ${LCM_PC} LCM_VERSION REGEX "^Version:")
  string(REGEX REPLACE "Version: *([0-9.]+).*" "\\1" LCM_VERSION "${LCM_VERSION}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LCM REQUIRED_VARS LCM_LIBRARY LCM_INCLUDE_DIR LCM_GEN_EXECUTABLE VERSION_VAR LCM_VERSION)
if(LCM_FOUND AND NOT TARGET LCM::LCM)
  add_library(LCM::LCM UNKNOWN IMPORTED)
  set_target_properties(LCM::LCM PROPERTIES IMPORTED_LOCATION ${LCM_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${LCM_INCLUDE_DIR})
endif()
mark_as_advanced(LCM_INCLUDE_DIR LCM_LIBRARY LCM_GEN_EXECUTABLE LCM_PC)
