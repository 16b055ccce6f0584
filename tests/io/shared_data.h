// Real point clouds that are too large to keep here.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

namespace tessera::testing_io {

inline const std::filesystem::path data = TESSERA_SHARED_DATA;

}  // namespace tessera::testing_io

#define REQUIRE_SHARED_DATA() \
  if (!std::filesystem::exists(tessera::testing_io::data)) GTEST_SKIP() << "no " << tessera::testing_io::data
