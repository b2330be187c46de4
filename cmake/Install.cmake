include(CMakePackageConfigHelpers)
install(TARGETS scslam EXPORT scslamTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET scslam_cli)
  install(TARGETS scslam_sim LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(TARGETS scslam_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY src/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/scslam FILES_MATCHING PATTERN "*.h" PATTERN cli EXCLUDE)
install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/scslam/configs)
install(EXPORT scslamTargets NAMESPACE scslam:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scslam)
configure_package_config_file(cmake/scslamConfig.cmake.in ${PROJECT_BINARY_DIR}/scslamConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scslam)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/scslamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/scslamConfig.cmake ${PROJECT_BINARY_DIR}/scslamConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/scslam)
