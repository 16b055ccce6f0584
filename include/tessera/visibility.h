// Marks what the shared library shows; everything else in it is hidden.
#pragma once

#define TESSERA_PUBLIC __attribute__((visibility("default")))
