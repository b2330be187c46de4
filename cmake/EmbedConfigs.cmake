# YAML files that are data of the program are compiled in, so that a single binary knows them by name.
# scslam_embed(OUTPUT_VARIABLE ROOT HEADER NAMESPACE FUNCTION glob…): a .cpp that defines
# const std::map<std::string, std::string>& NAMESPACE::FUNCTION(), keys relative to ROOT without extension.
function(scslam_embed output root header namespace function)
  set(globs ${ARGN})
  list(TRANSFORM globs PREPEND ${root}/)
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${root} ${globs})
  set(body "#include \"${header}\"\nnamespace ${namespace} {\nconst std::map<std::string, std::string>& ${function}() {\n  static const std::map<std::string, std::string> files = {\n")
  foreach(name IN LISTS files)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${root}/${name})
    file(READ ${root}/${name} text)
    string(REGEX REPLACE "\\.yaml$" "" key ${name})
    string(APPEND body "    {\"${key}\", R\"yaml(${text})yaml\"},\n")
  endforeach()
  string(APPEND body "  };\n  return files;\n}\n}  // namespace ${namespace}\n")
  set(file ${PROJECT_BINARY_DIR}/${function}.cpp)
  file(GENERATE OUTPUT ${file} CONTENT "${body}")
  set(${output} ${file} PARENT_SCOPE)
endfunction()
