# find_package(kilotouch) for other projects: target kilotouch::kilotouch, or one library at a time.
include(CMakePackageConfigHelpers)
add_library(kilotouch INTERFACE)
add_library(kilotouch::kilotouch ALIAS kilotouch)
target_link_libraries(kilotouch INTERFACE kt_haptics kt_self_contact kt_io kt_models kt_collision kt_core)

install(TARGETS kilotouch kt_core kt_collision kt_self_contact kt_models kt_io kt_haptics kt_arithmetic EXPORT kilotouch-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT kilotouch-targets NAMESPACE kilotouch:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kilotouch)
foreach(folder core collision self_contact models io haptics)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kilotouch
          FILES_MATCHING PATTERN "*.hpp" PATTERN "*.def")
endforeach()
configure_package_config_file(cmake/kilotouch-config.cmake.in kilotouch-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kilotouch)
write_basic_package_version_file(kilotouch-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kilotouch-config.cmake ${PROJECT_BINARY_DIR}/kilotouch-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kilotouch)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})
