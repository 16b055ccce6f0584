// How CAF reads and writes a message: its members, by the name x.
#pragma once

#include <caf/all.hpp>

#define TESSERA_MESSAGE(Type, ...)                                                  \
  template <class Inspector>                                                        \
  typename Inspector::result_type inspect(Inspector& f, [[maybe_unused]] Type& x) { \
    return f(caf::meta::type_name(#Type) __VA_OPT__(, ) __VA_ARGS__);               \
  }
