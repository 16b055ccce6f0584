# Precompiled headers: what nearly every source includes is parsed once, not a thousand times.
#
# Sources include what they use all the same: ./tessera.sh nightly builds with TESSERA_PRECOMPILED=OFF, too. A target whose
# sources share a heavy header names it in its property TESSERA_PRECOMPILED, and gets a precompiled header of its own.
option(TESSERA_PRECOMPILED "Precompile headers that many sources include" ON)

set(TESSERA_PRECOMPILED_COMMON
  <algorithm> <array> <atomic> <bit> <chrono> <cmath> <condition_variable> <cstdint> <cstring> <filesystem> <fstream>
  <functional> <limits> <map> <memory> <mutex> <numeric> <optional> <random> <set> <span> <sstream> <stop_token> <string>
  <string_view> <thread> <tuple> <type_traits> <utility> <variant> <vector>
  <boost/outcome/basic_result.hpp> <boost/outcome/try.hpp>)

# To be called last, after tessera_build_walls(). Libraries and programs are compiled with different options (-fPIC, -fPIE),
# tests with less optimisation, and a precompiled header goes with one set of options alone.
function(tessera_precompile_headers)
  if(NOT TESSERA_PRECOMPILED OR TESSERA_SANITIZE OR TESSERA_FUZZ)
    return()
  endif()
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled.cc CONTENT "int main() {}\n")
  tessera_targets_below(${PROJECT_SOURCE_DIR} targets)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    get_target_property(visibility ${target} CXX_VISIBILITY_PRESET)
    get_target_property(sources ${target} SOURCES)
    get_target_property(more ${target} TESSERA_PRECOMPILED)
    get_target_property(options ${target} COMPILE_OPTIONS)
    if("${options}" MATCHES "rounding-math|GLIBCXX_ASSERTIONS")
      continue()
    endif()
    get_target_property(links ${target} LINK_LIBRARIES)
    if(NOT "${links}" MATCHES "tessera_")  # stands alone, without the definitions that come with Boost
      continue()
    endif()
    if(type STREQUAL "INTERFACE_LIBRARY" OR NOT visibility STREQUAL "hidden" OR NOT "${sources}" MATCHES "[.]cc")
      continue()
    endif()
    if(more)
      target_precompile_headers(${target} PRIVATE ${TESSERA_PRECOMPILED_COMMON} ${more})
    elseif(NOT "${more}" STREQUAL "OFF")
      tessera_folder_of(${target} folder)
      set(kind library)
      if(type STREQUAL "EXECUTABLE")
        set(kind program)
      endif()
      if(folder MATCHES "^tests/")
        string(PREPEND kind "test_")
        if(NOT "${links}" MATCHES "GTest::")
          string(PREPEND kind "plain_")
        endif()
      endif()
      tessera_precompiled_of(${kind} ${target})
    endif()
  endforeach()
endfunction()

# Lets `target` use the precompiled header of that kind.
function(tessera_precompiled_of kind target)
  set(owner tessera_precompiled_${kind})
  if(NOT TARGET ${owner})
    if(kind MATCHES "program")
      add_executable(${owner} EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled.cc)
    else()
      add_library(${owner} STATIC EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/precompiled.cc)
    endif()
    target_link_libraries(${owner} PRIVATE Boost::headers Threads::Threads)
    target_precompile_headers(${owner} PRIVATE ${TESSERA_PRECOMPILED_COMMON})
    if(kind MATCHES "^test_")
      target_link_libraries(${owner} PRIVATE GTest::gtest)
      target_precompile_headers(${owner} PRIVATE <gtest/gtest.h>)
    endif()
    if(kind MATCHES "test_")
      if(TESSERA_TEST_FLAGS MATCHES "-O[0-9]")
        target_compile_options(${owner} PRIVATE $<$<CONFIG:Release>:${CMAKE_MATCH_0}>)
      endif()
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()
