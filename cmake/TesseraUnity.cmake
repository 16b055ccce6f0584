# Unity builds: some sources of a target are compiled together, so that the headers that they share are parsed once. A build
# of everything takes about half of the time; a change of one source compiles its neighbours, too.
#
# Sources are written as if each were alone: ./tessera.sh nightly builds with TESSERA_UNITY=OFF, too. Two sources of a target
# cannot give different things in their unnamed namespaces the same name.
option(TESSERA_UNITY "Compile several sources of a target together" ON)

# Kernels and the exchange are compiled source by source, so that what the compiler inlines there does not depend on their
# neighbours. What protobuf generates cannot be compiled together.
set(TESSERA_UNITY_ALONE "^(proto|src/geometry|src/exchange|(src/tiling|tests)/tile)(/|$)")

# Tests that have small functions of the same names as their neighbours; and what replaces the functions of memory.
set(TESSERA_UNITY_NAMESAKES
  tests/actors/router_test.cc tests/actors/share_account_test.cc tests/exchange/outbox_test.cc
  tests/exchange/outboxes_test.cc tests/exchange/tile_life_test.cc tests/input/off_reader_test.cc
  tests/input/pcd_reader_test.cc tests/input/stl_reader_test.cc tests/input/text_reader_test.cc
  tests/kernel/build_insert_test.cc tests/memory/failing_memory.cc tests/memory/job_memory_test.cc
  tests/region/memory_units.cc tests/service/staging_folder_test.cc tests/store/early_cells_test.cc
  tests/store/tile_store_test.cc tests/track/estimate_test.cc)

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
    get_target_property(sources ${target} SOURCES)
    foreach(source IN LISTS sources)
      if("${folder}/${source}" IN_LIST TESSERA_UNITY_NAMESAKES)
        set_source_files_properties(${PROJECT_SOURCE_DIR}/${folder}/${source} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      endif()
    endforeach()
    # The first warning is about types of unnamed namespaces in headers, and here each source is a header. GCC 12 gives the
    # second wrongly, about strings in temporary objects, the more often the more it inlines. Nightly builds have both.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage -Wno-maybe-uninitialized)
  endforeach()
endfunction()
