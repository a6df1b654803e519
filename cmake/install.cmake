# find_package(kilotouch) for other projects: target kilotouch::kilotouch, or one library at a time.
include(CMakePackageConfigHelpers)
add_library(kilotouch INTERFACE)
add_library(kilotouch::kilotouch ALIAS kilotouch)
target_link_libraries(kilotouch INTERFACE kt_api)

install(TARGETS kilotouch kt_api kt_shared kt_core kt_collision kt_self_contact kt_models kt_io kt_haptics kt_arithmetic
        EXPORT kilotouch-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
install(EXPORT kilotouch-targets NAMESPACE kilotouch:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kilotouch COMPONENT development)

# Public is api/kilotouch.hpp and what it includes, below include/kilotouch/: nobody's include path gets a folder `core`.
# Rooms of our house are no part of a public name: core/body/mesh.hpp is installed as core/mesh.hpp.
function(kt_public_name text out)
  string(REGEX REPLACE "(core|collision|io|haptics)/([a-z]+/)+" "\\1/" text "${text}")
  string(REGEX REPLACE "^api/" "" text "${text}")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()
function(kt_install_header file)
  get_property(done GLOBAL PROPERTY KT_PUBLIC_HEADERS)
  if(file IN_LIST done)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY KT_PUBLIC_HEADERS ${file})
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
  file(READ ${PROJECT_SOURCE_DIR}/${file} content)
  string(REGEX MATCHALL "#include \"[^\"]+\"" includes "${content}")
  foreach(include ${includes})
    string(REGEX REPLACE "#include \"([^\"]+)\"" "\\1" include ${include})
    kt_install_header(${include})
  endforeach()
  string(REGEX REPLACE "#include \"" "#include \"kilotouch/" content "${content}")
  kt_public_name("${content}" content)
  kt_public_name(${file} public)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/include/kilotouch/${public} CONTENT "${content}" @ONLY)
endfunction()
file(REMOVE_RECURSE ${PROJECT_BINARY_DIR}/include)
kt_install_header(api/kilotouch.hpp)
kt_install_header(api/kilotouch.h)
install(DIRECTORY ${PROJECT_BINARY_DIR}/include/kilotouch DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
configure_package_config_file(cmake/kilotouch-config.cmake.in kilotouch-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kilotouch)
write_basic_package_version_file(kilotouch-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/kilotouch-config.cmake ${PROJECT_BINARY_DIR}/kilotouch-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kilotouch COMPONENT development)
if(NOT KT_PACKAGING)  # Debian's packages name the licence in their own way, and have a folder each
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN __pycache__ EXCLUDE)
endif()
