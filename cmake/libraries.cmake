# One static library per line of the dependency order (docs/architecture.md). A new backend is one .cpp in its folder:
# the globs pick it up at the next build. A .cpp that needs an optional package is left out when the package is off.
function(kt_library name)
  cmake_parse_arguments(ARG "" "QUICK" "DIRS;DEPENDS;WITHOUT;ALONE" ${ARGN})
  set(sources)
  foreach(dir ${ARG_DIRS})
    file(GLOB found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${dir}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  foreach(pattern ${ARG_WITHOUT})
    list(FILTER sources EXCLUDE REGEX "${pattern}")
  endforeach()
  set(quick)
  if(KT_QUICK_BUILD AND ARG_QUICK AND CMAKE_BUILD_TYPE STREQUAL "Release")
    set(quick ${sources})
    list(FILTER quick INCLUDE REGEX "${ARG_QUICK}")
    list(FILTER sources EXCLUDE REGEX "${ARG_QUICK}")
  endif()
  add_library(kt_${name} STATIC ${sources})
  if(quick)  # in the same archive, with flags of its own
    add_library(kt_${name}_quick OBJECT ${quick})
    target_include_directories(kt_${name}_quick PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(kt_${name}_quick PRIVATE ${ARG_DEPENDS} kt_arithmetic kt_flags)
    kt_unity(kt_${name}_quick EXCEPT ${ARG_ALONE})
    kt_quick(kt_${name}_quick)
    target_sources(kt_${name} PRIVATE $<TARGET_OBJECTS:kt_${name}_quick>)
  endif()
  add_library(kilotouch::${name} ALIAS kt_${name})
  set_target_properties(kt_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(kt_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                               $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(kt_${name} PUBLIC cxx_std_20)
  target_link_libraries(kt_${name} PUBLIC ${ARG_DEPENDS} kt_arithmetic PRIVATE $<BUILD_INTERFACE:kt_flags>)
  kt_unity(kt_${name} EXCEPT ${ARG_ALONE})
endfunction()

# Sources that need a package which is off. Their entry in the .def table stays and says which option turns it on.
set(kt_off)
foreach(pair "CHOLMOD=core/linear/cholmod" "EMBREE=collision/broad/embree" "OPENMESH=[a-z]*/[a-z_]*openmesh"
             "CGAL=io/([a-z]+/)*[a-z_]*cgal" "TETGEN=io/([a-z]+/)*[a-z_]*tetgen"
             "NETGEN=io/([a-z]+/)*[a-z_]*netgen" "ZLIB=io/([a-z]+/)*[a-z_]*zlib" "HAPLY=(haptics|driver)/haply")
  string(REPLACE "=" ";" pair ${pair})
  list(GET pair 0 option)
  list(GET pair 1 path)
  if(NOT KT_WITH_${option})
    list(APPEND kt_off ${path})
  endif()
endforeach()
if(NOT KT_BUILD_APPS)
  list(APPEND kt_off "io/([a-z]+/)*[a-z_]*json" "io/scene/(named_here|scene)" "io/scene_")
endif()

# ALONE: never compiled together with neighbours (KT_UNITY): the loops of the tick, whose code must not depend on it; CGAL,
# whose files take a minute each; and files that share the name of a local helper with a neighbour.
kt_library(core DIRS core/base core/linear core/linear/dense core/linear/step_solvers core/body core/global core/global/integrators core/local
                         core/local/reducers core/contact_surface core/fine
           DEPENDS Eigen3::Eigen WITHOUT ${kt_off}
           ALONE core/linear/[a-z]*/?[a-z]*_product core/linear/dense/dense_cholesky core/linear/dense/symmetric_eigen core/linear/block_cholesky
                 core/linear/dense/complex_symmetric core/linear/supernodes core/global/newton core/local/block_confinement
                 core/local/node_blocks core/local/local_dynamics core/local/graded_body core/base/finding
                 core/base/temporary_folder)
kt_library(collision DIRS collision/shape collision/impact collision/broad collision/held DEPENDS kt_core
           WITHOUT ${kt_off} ALONE collision/)
kt_library(self_contact DIRS self_contact DEPENDS kt_core kt_collision)
kt_library(models DIRS models models/msd models/fem models/fem/materials DEPENDS kt_core ALONE models/fem/deformation)
kt_library(io DIRS io/files io/mesh io/mesh/format io/surface io/solid io/scene DEPENDS kt_core WITHOUT ${kt_off}
           QUICK "(io/(files|mesh|mesh/format|scene)/|_cgal)"
           ALONE _cgal io/mesh/format/ply.cpp io/mesh/format/stl.cpp io/mesh/format/vtk.cpp io/mesh/format/medit io/files/json_batch io/files/json_file io/scene/json_rules)
set(kt_baselines)
if(KT_WITH_LAB)
  set(kt_baselines lab/methods)
endif()
kt_library(haptics DIRS haptics/contact haptics/device haptics/safety haptics/machine haptics/driver haptics/driver/haply haptics/guard haptics/link haptics/tick
                            haptics/cost haptics/touched haptics/refresh haptics/remote haptics/body haptics/halves haptics/watch haptics/touch
                            haptics/setup haptics/cells haptics/predict haptics/session haptics/findings ${kt_baselines}
           QUICK "haptics/(driver|setup|predict|session|findings)/"
           WITHOUT ${kt_off}
           ALONE "haptics/tick/(tick_|free_motion|first_impact|coulomb_|paper_tick|model_change|local_simulation)"
                 haptics/contact/ haptics/touch/thread_link haptics/touch/lockstep_link
                 haptics/findings/ haptics/session/real_time
                 haptics/cells/mesh_cures haptics/predict/predict_tool_mesh
                 haptics/driver/haply/ haptics/guard/ haptics/watch/ haptics/session/metrics
                 haptics/refresh/kept_set_up
           DEPENDS kt_core kt_collision kt_self_contact kt_models kt_io Threads::Threads)

# Rooms of which nothing is a loop of the tick, and which a tick's files do not include.
foreach(name haptics haptics_quick)
  if(TARGET kt_${name})
    kt_join(kt_${name} findings "haptics/(findings/|session/(metrics|real_time)\\.|predict/predict_tool_mesh|cells/mesh_cures)")
    kt_join(kt_${name} watch "haptics/(watch/|guard/(device_identify|device_test|followed_pose)\\.|refresh/kept_set_up)")
  endif()
endforeach()
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize")  # no machine code there whose speed matters
  kt_join(kt_haptics contact "haptics/contact/")
  kt_join(kt_collision impact "collision/impact/(bernstein|expansion|feature_toi|four_points|touch)\\.")
  kt_join(kt_collision broad "collision/broad/(brute_force|refit_bvh|surface_pairs|triangle_index|wide_tree)\\.")
  kt_join(kt_collision held "collision/(held/(chosen_places|moving_tool|pair_distance|surface_contacts|vertex_contacts)|shape/closest_point)\\.")
  kt_join(kt_core linear "core/linear/(block_cholesky|sparse_product|supernodes|dense/(complex_symmetric|dense_cholesky|dense_product|panel_product))\\.")
  kt_join(kt_core local "core/(local/(block_confinement|graded_body|local_dynamics|node_blocks)|global/newton|base/(finding|temporary_folder))\\.")
endif()

kt_library(api DIRS api DEPENDS kt_core kt_collision kt_self_contact kt_models kt_io kt_haptics)

# The C interface as one shared library: everything inside, nothing but kt_* outside.
add_library(kt_shared SHARED api/c_api.cpp api/held_touch.cpp)
set_target_properties(kt_shared PROPERTIES OUTPUT_NAME kilotouch EXPORT_NAME shared VERSION ${PROJECT_VERSION} SOVERSION 0
                      CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
target_include_directories(kt_shared PRIVATE ${PROJECT_SOURCE_DIR} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_compile_features(kt_shared PRIVATE cxx_std_20)
target_link_libraries(kt_shared PRIVATE $<BUILD_INTERFACE:kt_flags> $<BUILD_INTERFACE:kt_haptics>)
target_link_options(kt_shared PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/api/kilotouch.map)
foreach(target kt_api kt_shared)
  target_compile_definitions(${target} PRIVATE KT_VERSION="${PROJECT_VERSION}" KT_BUILD_APPS=$<BOOL:${KT_BUILD_APPS}>)
endforeach()

# Which optional parts are in, as 0/1 macros for the .def tables.
foreach(option CHOLMOD TBB EMBREE OPENMESH CGAL TETGEN NETGEN BEAST)
  target_compile_definitions(kt_core PUBLIC KT_WITH_${option}=$<BOOL:${KT_WITH_${option}}>)
endforeach()

# Of single files: the others need not be compiled anew for it.
if(NOT KT_WITH_HAPLY)  # else as KT_WITH_BEAST
  set_source_files_properties(haptics/device/haptic_device.cpp haptics/driver/find_devices.cpp PROPERTIES
                              COMPILE_DEFINITIONS KT_WITH_HAPLY=0)
endif()
set_source_files_properties(haptics/setup/session_parts.cpp PROPERTIES COMPILE_DEFINITIONS KT_WITH_NETWORK=$<BOOL:${KT_WITH_NETWORK}>)
set_source_files_properties(haptics/tick/haptic_method.cpp PROPERTIES COMPILE_DEFINITIONS KT_WITH_LAB=$<BOOL:${KT_WITH_LAB}>)

target_link_libraries(kt_io PRIVATE $<BUILD_INTERFACE:kt_hardened>)
if(TARGET kt_io_quick)
  target_link_libraries(kt_io_quick PRIVATE kt_hardened)
endif()
target_link_libraries(kt_haptics PRIVATE ${CMAKE_DL_LIBS})  # vendors' libraries of devices are loaded where they are used

kt_precompile(kt_core)
foreach(name collision self_contact models haptics haptics_quick)
  if(TARGET kt_${name})
    kt_precompile(kt_${name} FROM kt_core)
  endif()
endforeach()
foreach(name io io_quick)  # of their own: they are hardened, and CGAL brings -frounding-math
  if(TARGET kt_${name})
    kt_precompile(kt_${name})
  endif()
endforeach()

if(KT_WITH_CHOLMOD)
  target_include_directories(kt_core PRIVATE ${KT_CHOLMOD_INCLUDE})
  target_link_libraries(kt_core PRIVATE ${KT_CHOLMOD_LIBRARY} gomp)
endif()
if(KT_WITH_TBB)
  target_link_libraries(kt_core PRIVATE TBB::tbb)
endif()
if(KT_WITH_EMBREE)
  target_link_libraries(kt_collision PRIVATE embree)
  set_source_files_properties(collision/broad/embree.cpp PROPERTIES COMPILE_DEFINITIONS KT_EMBREE_MAJOR=${embree_VERSION_MAJOR})
endif()
if(KT_WITH_OPENMESH)
  target_link_libraries(kt_io PRIVATE OpenMeshCore)
endif()
if(KT_WITH_CGAL)
  target_link_libraries(kt_io PRIVATE CGAL::CGAL)
  if(TARGET kt_io_quick)
    target_link_libraries(kt_io_quick PRIVATE CGAL::CGAL)
  endif()
endif()
if(KT_WITH_ZLIB)
  target_link_libraries(kt_io PRIVATE ZLIB::ZLIB)
endif()
# Of one file only: the others need not be compiled anew for it.
set_source_files_properties(io/mesh/format/vtu_array.cpp PROPERTIES COMPILE_DEFINITIONS KT_WITH_ZLIB=$<BOOL:${KT_WITH_ZLIB}>)
if(KT_WITH_NETGEN)
  target_include_directories(kt_io PRIVATE ${KT_NETGEN_INCLUDE})
  # Loaded where it is used, by its full path: with the name that stays when the development package goes.
  file(REAL_PATH ${KT_NETGEN_LIBRARY} netgen)
  set_source_files_properties(io/solid/tetrahedralize_netgen.cpp PROPERTIES COMPILE_DEFINITIONS KT_NETGEN_LIBRARY="${netgen}")
  target_link_libraries(kt_io PRIVATE ${CMAKE_DL_LIBS})
endif()
if(KT_BUILD_APPS)
  # The scene schema travels inside the library, so an installed command works from any folder.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/io/scene/scene.schema.json)
  file(READ ${PROJECT_SOURCE_DIR}/io/scene/scene.schema.json KT_SCENE_SCHEMA)
  configure_file(io/scene/scene_schema.cpp.in scene_schema.cpp @ONLY)
  target_sources(kt_io PRIVATE ${PROJECT_BINARY_DIR}/scene_schema.cpp)
  target_include_directories(kt_io PRIVATE ${KT_VALIJSON_INCLUDE})
  target_link_libraries(kt_io PUBLIC nlohmann_json::nlohmann_json)
endif()
