// Included by all public headers: checks the compiler and defines TESSERA_PUBLIC.
#pragma once

#if __cplusplus < 202002L
#error "The headers of Tessera need C++20: compile with -std=c++20 (linking tessera::tessera in CMake asks for it)"
#endif

// Marks what the shared library exports. All other symbols are hidden.
#define TESSERA_PUBLIC __attribute__((visibility("default")))
