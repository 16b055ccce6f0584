// Declares how CAF reads and writes a message. The arguments after the type are its members, written as members of `x`.
#pragma once

#include <caf/all.hpp>

#define TESSERA_MESSAGE(Type, ...)                                                  \
  template <class Inspector>                                                        \
  typename Inspector::result_type inspect(Inspector& f, [[maybe_unused]] Type& x) { \
    return f(caf::meta::type_name(#Type) __VA_OPT__(, ) __VA_ARGS__);               \
  }

// Declares a message that never leaves its process. CAF has no name for such a message and cannot read one, so no other
// process can send it. REQUIRES: used in the global namespace.
#define TESSERA_STAYS_HERE(Type) CAF_ALLOW_UNSAFE_MESSAGE_TYPE(Type)
