// The functions of GDAL for files of its virtual file systems, such as stores of objects.
#pragma once

#include <cpl_vsi.h>

#include "src/base/result.h"

namespace tessera {

// clang-format off
#define TESSERA_GDAL_FILE_FUNCTIONS(F) \
  F(VSICurlPartialClearCache) F(VSIFCloseL) F(VSIFOpenL) F(VSIFReadL) F(VSIFSeekL) F(VSIReadDirEx) \
  F(VSIReadDirRecursive) F(VSIStatExL)
// clang-format on

struct GdalFiles {
#define TESSERA_GDAL_MEMBER(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TESSERA_GDAL_FILE_FUNCTIONS(TESSERA_GDAL_MEMBER)
#undef TESSERA_GDAL_MEMBER
};

// The functions of the library that gdal_library() loads. Error as there. Thread-safe.
Result<const GdalFiles*> gdal_files();

}  // namespace tessera
