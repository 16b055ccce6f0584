// What all public headers begin with.
#pragma once

#if __cplusplus < 202002L
#error "The headers of Tessera need C++20: compile with -std=c++20 (linking tessera::tessera in CMake asks for it)"
#endif

// Marks what the shared library shows; everything else in it is hidden.
#define TESSERA_PUBLIC __attribute__((visibility("default")))
