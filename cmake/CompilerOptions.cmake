# One binary for every x86-64: no -march. Hot kernels carry an AVX2 copy that the loader picks by CPUID (src/core/simd.h).
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(SCSLAM_CCACHE ccache)
if(SCSLAM_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${SCSLAM_CCACHE})
endif()
find_program(SCSLAM_LLD ld.lld)
if(SCSLAM_LLD)
  add_link_options(-fuse-ld=lld)
endif()

add_library(scslam_options INTERFACE)
# No contraction: the AVX2 and the baseline copy of a kernel, and any two machines, give the same bits.
target_compile_options(scslam_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
                       -ffp-contract=off -fno-math-errno)
if(SCSLAM_WERROR)
  target_compile_options(scslam_options INTERFACE -Werror)
endif()
# Debian's Ceres and MRPT are built with Eigen's SSE alignment; keep it whatever flags a user adds.
target_compile_definitions(scslam_options INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
if(SCSLAM_SANITIZE)
  target_compile_options(scslam_options INTERFACE -fsanitize=${SCSLAM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(SCSLAM_SANITIZE MATCHES undefined)
    # These checks sit in every access of Eigen's, where the address sanitizer looks, too: a third of the compilation.
    target_compile_options(scslam_options INTERFACE -fno-sanitize=null,alignment,object-size,vptr)
  endif()
  add_link_options(-fsanitize=${SCSLAM_SANITIZE})
  target_compile_definitions(scslam_options INTERFACE SCSLAM_NO_MULTIVERSION)
endif()
if(SCSLAM_COVERAGE)  # atomic: several threads count
  target_compile_options(scslam_options INTERFACE --coverage -fprofile-update=atomic -O1)
  add_link_options(--coverage)
endif()

# Eigen, fmt and the standard library are most of what the compiler reads.
set(SCSLAM_COMMON_HEADERS <algorithm> <functional> <map> <memory> <optional> <string> <vector> <Eigen/Core> <Eigen/Geometry>
    <fmt/format.h>)
# scslam_precompile(TARGET FIRST header...): FIRST is the target, or one of the same flags whose precompiled headers serve.
function(scslam_precompile target first)
  if(NOT SCSLAM_PCH)
    return()
  endif()
  if(target STREQUAL first OR NOT TARGET ${first})
    target_precompile_headers(${target} PRIVATE ${SCSLAM_COMMON_HEADERS} ${ARGN})
  else()
    target_precompile_headers(${target} REUSE_FROM ${first})
  endif()
endfunction()
