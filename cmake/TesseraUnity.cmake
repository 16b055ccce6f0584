# Unity builds: some sources of a target are compiled together, so that the headers that they share are parsed once. A build
# of everything takes about half of the time; a change of one source compiles its neighbours, too.
#
# Sources are written as if each were alone: ./tessera.sh nightly builds with TESSERA_UNITY=OFF, too. Two sources of a target
# cannot give different things in their unnamed namespaces the same name.
option(TESSERA_UNITY "Compile several sources of a target together" ON)

# Kernels and the exchange are compiled source by source, so that what the compiler inlines there does not depend on their
# neighbours. What protobuf generates cannot be compiled together. Tests have few sources a program, and many small
# functions of the same names.
set(TESSERA_UNITY_ALONE "^(proto|src/geometry|src/exchange|src/tiling/tile|tests)(/|$)")

# To be called after all targets are made.
function(tessera_unity_builds)
  if(NOT TESSERA_UNITY OR TESSERA_SANITIZE OR TESSERA_FUZZ)
    return()
  endif()
  tessera_targets_below(${PROJECT_SOURCE_DIR} targets)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    tessera_folder_of(${target} folder)
    if(type STREQUAL "INTERFACE_LIBRARY" OR folder MATCHES "${TESSERA_UNITY_ALONE}")
      continue()
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
    # The first warning is about types of unnamed namespaces in headers, and here each source is a header. GCC 12 gives the
    # second wrongly, about strings in temporary objects, the more often the more it inlines. Nightly builds have both.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage -Wno-maybe-uninitialized)
  endforeach()
endfunction()
