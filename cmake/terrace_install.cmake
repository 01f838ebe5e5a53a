# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` lays down: the daemon, the toolbox, the client library with its CMake package and pkg-config
# file, the message types, the systemd unit and the default configuration.

install(TARGETS terraced terrace RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# Every folder is a target terrace::FOLDER. A planner links terrace::client and needs nothing but Eigen and LCM; whoever
# builds on the mapper itself asks for the component `mapper`.
install(TARGETS terrace_core terrace_lcmtypes terrace_client EXPORT terrace-client
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS terrace_parallel_for terrace_files terrace_results terrace_stereo terrace_odometry terrace_mapping terrace_polygonization terrace_labeling terrace_terrain terrace_datasets
                terrace_evaluation terrace_image_codec
        EXPORT terrace-mapper ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(folder core results lcmtypes client stereo odometry mapping polygonization labeling terrain datasets evaluation)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/terrace
          FILES_MATCHING PATTERN "*.h")
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/lcmtypes/cpp/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/terrace
        FILES_MATCHING PATTERN "*.hpp")

set(PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/terrace)
foreach(set client mapper)
  install(EXPORT terrace-${set} NAMESPACE terrace:: DESTINATION ${PACKAGE_DIR} FILE terrace-${set}-targets.cmake)
endforeach()
configure_package_config_file(cmake/terrace-config.cmake.in ${PROJECT_BINARY_DIR}/terrace-config.cmake
                              INSTALL_DESTINATION ${PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/terrace-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/terrace-config.cmake ${PROJECT_BINARY_DIR}/terrace-config-version.cmake
              cmake/FindLCM.cmake cmake/FindPolyclipping.cmake
        DESTINATION ${PACKAGE_DIR})
configure_file(cmake/terrace-client.pc.in ${PROJECT_BINARY_DIR}/terrace-client.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/terrace-client.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(DIRECTORY lcmtypes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/terrace/lcmtypes FILES_MATCHING PATTERN "*.lcm")
# scripts/viewer makes the page where there is npm; one page for every preset.
install(FILES ${PROJECT_SOURCE_DIR}/build/viewer/index.html DESTINATION ${CMAKE_INSTALL_DATADIR}/terrace RENAME view.html OPTIONAL)
install(DIRECTORY datasets/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/terrace OPTIONAL)
install(FILES daemon/config/terraced.yaml DESTINATION ${CMAKE_INSTALL_SYSCONFDIR}/terrace)
configure_file(daemon/terraced.service.in ${PROJECT_BINARY_DIR}/terraced.service @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/terraced.service daemon/config/terrace-loopback.service DESTINATION lib/systemd/system)
install(DIRECTORY daemon/config/ DESTINATION lib/sysctl.d FILES_MATCHING PATTERN "*.conf")
