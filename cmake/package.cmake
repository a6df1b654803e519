# Debian's packages, by CPack: the program, the C library, what compiles against both libraries, Python, the manual.
# scripts/package makes and names them. Every file of Debian's own (copyright, changelogs, the compressed manual page) is made here.
file(STRINGS /etc/os-release system REGEX "^(ID|VERSION_ID)=")
foreach(line ${system})
  if(line MATCHES "^(ID|VERSION_ID)=\"?([^\"]+)\"?$")
    set(system_${CMAKE_MATCH_1} ${CMAKE_MATCH_2})
  endif()
endforeach()
set(KT_DEBIAN_VERSION ${PROJECT_VERSION}-1~${system_ID}${system_VERSION_ID})
set(KT_MAINTAINER "the kilotouch authors <$ENV{DEBEMAIL}>")
if("$ENV{DEBEMAIL}" STREQUAL "")
  execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%ae OUTPUT_VARIABLE email OUTPUT_STRIP_TRAILING_WHITESPACE)
  set(KT_MAINTAINER "the kilotouch authors <${email}>")
endif()
execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%cD OUTPUT_VARIABLE KT_DEBIAN_DATE OUTPUT_STRIP_TRAILING_WHITESPACE)
execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --date=format:%Y --format=%cd OUTPUT_VARIABLE KT_YEAR OUTPUT_STRIP_TRAILING_WHITESPACE)

# What is compiled into the packages and is not ours; the libraries that they are linked with have packages of their own.
set(made ${PROJECT_BINARY_DIR}/packaging)
set(others "")
foreach(package libeigen3-dev libspectra-dev nlohmann-json3-dev libvalijson-dev libcli11-dev libboost-dev cppzmq-dev
                libflatbuffers-dev pybind11-dev libjs-three)
  foreach(place ${package} ${package}-copyright)
    if(EXISTS /usr/share/doc/${place}/copyright)
      file(READ /usr/share/doc/${place}/copyright text)
      string(APPEND others "======== ${package}\n\n${text}\n\n")
    endif()
  endforeach()
endforeach()
file(CONFIGURE OUTPUT ${made}/licences_of_others CONTENT "${others}" @ONLY)
configure_file(packaging/copyright.in ${made}/copyright @ONLY)
file(CONFIGURE OUTPUT ${made}/shlibs CONTENT "libkilotouch 0 libkilotouch0 (>= ${PROJECT_VERSION})\n" @ONLY)
file(CONFIGURE OUTPUT ${made}/triggers CONTENT "activate-noawait ldconfig\n" @ONLY)
configure_file(packaging/changelog.in ${made}/changelog.Debian @ONLY)
configure_file(${PROJECT_SOURCE_DIR}/CHANGELOG.md ${made}/changelog COPYONLY)
configure_file(${PROJECT_SOURCE_DIR}/docs/kilotouch.1 ${made}/kilotouch.1 COPYONLY)
foreach(file changelog.Debian changelog kilotouch.1 licences_of_others)
  execute_process(COMMAND gzip -9nkf ${made}/${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
install(FILES ${made}/kilotouch.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libkilotouch-dev/examples
        COMPONENT development PATTERN __pycache__ EXCLUDE)
install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/html DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/kilotouch-doc COMPONENT documentation)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME kilotouch)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # else each package begins with it
set(CPACK_PACKAGE_VENDOR "the kilotouch authors")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_VERSION ${KT_DEBIAN_VERSION})
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${KT_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# kt_package(component NAME package SECTION section SUMMARY text TEXT text FIELDS field value...)
set(CPACK_COMPONENTS_ALL)
function(kt_package component)
  cmake_parse_arguments(ARG "" "NAME;SECTION;SUMMARY;TEXT" "FIELDS" ${ARGN})
  install(FILES ${made}/copyright ${made}/changelog.Debian.gz ${made}/changelog.gz ${PROJECT_SOURCE_DIR}/NOTICE
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${ARG_NAME} COMPONENT ${component})
  if(NOT component STREQUAL "documentation")
    install(FILES ${made}/licences_of_others.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${ARG_NAME} COMPONENT ${component})
  endif()
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${ARG_NAME} PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_SECTION ${ARG_SECTION} PARENT_SCOPE)
  set(CPACK_COMPONENT_${COMPONENT}_DESCRIPTION "${ARG_SUMMARY}\n${ARG_TEXT}" PARENT_SCOPE)
  while(ARG_FIELDS)
    list(POP_FRONT ARG_FIELDS field value)
    set(CPACK_DEBIAN_${COMPONENT}_${field} "${value}" PARENT_SCOPE)
  endwhile()
endfunction()

set(about "kilotouch computes, a thousand times a second, the force that a tool feels
when it touches a soft body: where the body sticks to the tool, where it
slips, and when it lets go.
")
kt_package(program NAME kilotouch SECTION science SUMMARY "haptic-rate contact with deformable objects"
           TEXT "${about}This package has the program: runs with reports, the live page, meshes,\ndevices."
           FIELDS PACKAGE_SHLIBDEPS ON PACKAGE_DEPENDS python3
                  PACKAGE_RECOMMENDS "tetgen, python3-numpy, python3-matplotlib, python3-jinja2, libjs-three, libjs-chart.js, libjs-jquery, libjs-jquery-datatables, xdg-utils"
                  PACKAGE_SUGGESTS "libnglib-6.2, kilotouch-doc")
kt_package(library NAME libkilotouch0 SECTION libs SUMMARY "haptic-rate contact with deformable objects: C library"
           TEXT "${about}This package has the library for C, C# and others that call C."
           FIELDS PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${made}/shlibs ${made}/triggers)
kt_package(development NAME libkilotouch-dev SECTION libdevel
           SUMMARY "haptic-rate contact with deformable objects: headers, C++ libraries"
           TEXT "${about}This package has the headers, the libraries of C++, CMake's files and\nexamples."
           FIELDS PACKAGE_DEPENDS "libkilotouch0 (= ${KT_DEBIAN_VERSION}), libeigen3-dev, libtbb-dev, libembree-dev, libopenmesh-dev, zlib1g-dev, nlohmann-json3-dev")
string(REGEX MATCH "^3\\.[0-9]+" python "${PYTHON_VERSION}")
string(REGEX MATCH "[0-9]+$" minor "${python}")
math(EXPR minor "${minor} + 1")
kt_package(python NAME python3-kilotouch SECTION python SUMMARY "haptic-rate contact with deformable objects: Python"
           TEXT "${about}This package has the module for Python."
           FIELDS PACKAGE_SHLIBDEPS ON PACKAGE_DEPENDS "python3 (>= ${python}), python3 (<< 3.${minor}), python3-numpy"
                  PACKAGE_RECOMMENDS "kilotouch, python3-scipy, python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/postinst ${PROJECT_SOURCE_DIR}/packaging/prerm)
kt_package(documentation NAME kilotouch-doc SECTION doc SUMMARY "haptic-rate contact with deformable objects: manual"
           TEXT "${about}This package has the manual as pages with a search, which need no\nnetwork."
           FIELDS PACKAGE_ARCHITECTURE all)
include(CPack)
