# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` lays down: the daemon, the toolbox, the client library with its CMake package and pkg-config
# file, the message types, the systemd unit and the default configuration. With `--component planner`: what a planner
# builds against and nothing else. All of it works under any `--prefix`.

install(TARGETS terraced terrace RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# Every folder is a target terrace::FOLDER. A planner links terrace::client and needs nothing but Eigen and LCM; whoever
# builds on the mapper itself asks for the component `mapper`.
install(TARGETS terrace_core terrace_lcmtypes terrace_client EXPORT terrace-client
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT planner)
install(TARGETS terrace_parallel_for terrace_files terrace_results terrace_stereo terrace_odometry terrace_mapping terrace_polygonization terrace_labeling terrace_terrain terrace_datasets
                terrace_evaluation terrace_image_codec
        EXPORT terrace-mapper ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
# All headers lie below terrace/ and name one another so, since a planner may have a core/geometry.h of its own.
function(terrace_install_headers)
  cmake_parse_arguments(ARG "" "COMPONENT" "FOLDERS" ${ARGN})
  foreach(folder ${ARG_FOLDERS})
    file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/${folder}/*.h)
    foreach(header ${headers})
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
      file(READ ${PROJECT_SOURCE_DIR}/${header} text)
      string(REGEX REPLACE "#include \"([a-z]+/)" "#include \"terrace/\\1" text "${text}")
      file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/installed/terrace/${header} CONTENT "${text}" @ONLY)
    endforeach()
    install(DIRECTORY ${PROJECT_BINARY_DIR}/installed/terrace/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/terrace
            COMPONENT ${ARG_COMPONENT} FILES_MATCHING PATTERN "*.h")
  endforeach()
endfunction()
terrace_install_headers(COMPONENT planner FOLDERS core lcmtypes client)
terrace_install_headers(COMPONENT Unspecified
                        FOLDERS results stereo odometry mapping polygonization labeling terrain datasets evaluation)
install(DIRECTORY ${PROJECT_BINARY_DIR}/lcmtypes/cpp/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT planner
        FILES_MATCHING PATTERN "*.hpp")

set(PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/terrace)
install(EXPORT terrace-client NAMESPACE terrace:: DESTINATION ${PACKAGE_DIR} FILE terrace-client-targets.cmake COMPONENT planner)
install(EXPORT terrace-mapper NAMESPACE terrace:: DESTINATION ${PACKAGE_DIR} FILE terrace-mapper-targets.cmake)
configure_package_config_file(cmake/terrace-config.cmake.in ${PROJECT_BINARY_DIR}/terrace-config.cmake
                              INSTALL_DESTINATION ${PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/terrace-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/terrace-config.cmake ${PROJECT_BINARY_DIR}/terrace-config-version.cmake
              cmake/FindLCM.cmake cmake/FindPolyclipping.cmake
        DESTINATION ${PACKAGE_DIR} COMPONENT planner)
# From where the file lies to the prefix, whatever that will be.
file(RELATIVE_PATH TERRACE_PC_TO_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/terrace-client.pc.in ${PROJECT_BINARY_DIR}/terrace-client.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/terrace-client.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT planner)

install(DIRECTORY lcmtypes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/terrace/lcmtypes COMPONENT planner FILES_MATCHING PATTERN "*.lcm")
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT planner)
install(FILES client/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/client COMPONENT planner)
install(FILES lcmtypes/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/lcmtypes COMPONENT planner)
install(DIRECTORY client/example DESTINATION ${CMAKE_INSTALL_DOCDIR}/client COMPONENT planner)
# scripts/viewer makes the page where there is npm; one page for every preset.
install(FILES ${PROJECT_SOURCE_DIR}/build/viewer/index.html DESTINATION ${CMAKE_INSTALL_DATADIR}/terrace RENAME view.html OPTIONAL)
install(DIRECTORY datasets/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/terrace OPTIONAL)
install(FILES daemon/config/terraced.yaml DESTINATION ${CMAKE_INSTALL_SYSCONFDIR}/terrace)
# The unit names files by their whole paths, which are known when the prefix is.
install(CODE "
  set(TERRACE_BIN_DIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
  set(TERRACE_CONFIG_DIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_SYSCONFDIR}/terrace\")
  configure_file(\"${PROJECT_SOURCE_DIR}/daemon/terraced.service.in\"
                 \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/system/terraced.service\" @ONLY)")
install(FILES daemon/config/terrace-loopback.service DESTINATION lib/systemd/system)
install(DIRECTORY daemon/config/ DESTINATION lib/sysctl.d FILES_MATCHING PATTERN "*.conf")
