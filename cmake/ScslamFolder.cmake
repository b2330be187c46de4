# scslam_add_folder(NAME [PLUGINS sub...] [PRIVATE targets...]): src/NAME/*.cpp and its plug-in folders become one OBJECT
# library inside libscslam. Files are globbed: a new file is built with no edit here, and because the objects themselves
# are linked (not a static library) its registration cannot be dropped.
function(scslam_add_folder name)
  if(SCSLAM_FOLDERS AND NOT name IN_LIST SCSLAM_FOLDERS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "PLUGINS;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  foreach(sub IN LISTS ARG_PLUGINS)
    file(GLOB plugins CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/${sub}/*.cpp
         ${PROJECT_SOURCE_DIR}/src/${name}/${sub}/*/*.cpp)  # a plug-in may be a small folder of its own
    list(APPEND sources ${plugins})
  endforeach()
  if(NOT sources)
    return()
  endif()
  add_library(scslam_${name} OBJECT ${sources})
  target_include_directories(scslam_${name} PRIVATE ${PROJECT_BINARY_DIR}/include)
  target_link_libraries(scslam_${name} PRIVATE scslam_options Eigen3::Eigen fmt::fmt mrpt::maps mrpt::graphs yaml-cpp
                        nlohmann_json::nlohmann_json ZLIB::ZLIB Threads::Threads ${ARG_PRIVATE})
  scslam_precompile(scslam_${name} scslam_core)
  target_sources(scslam PRIVATE $<TARGET_OBJECTS:scslam_${name}>)
endfunction()
