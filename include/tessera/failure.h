// How everything in the public library fails: by one exception type.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "tessera/visibility.h"

namespace tessera {

// The groups of docs/exit-status.md.
enum class Cause : std::uint8_t {
  usage = 2,        // an argument that makes no sense
  bad_input = 3,    // points or files that cannot be triangulated
  io = 4,           // the system refused
  corrupt = 5,      // a result that is damaged
  memory = 7,       // not within the memory given
  interrupted = 8,  // a stop was requested
  internal = 9,     // a mistake of ours
};

// what() is one sentence: which file or argument, which place, what is wrong.
class TESSERA_PUBLIC Failure : public std::runtime_error {
 public:
  Failure(Cause cause, const std::string& sentence) : std::runtime_error(sentence), cause_(cause) {}
  Failure(const Failure&) = default;
  Failure& operator=(const Failure&) = default;
  ~Failure() override;  // not here, so that its type is one in program and library
  Cause cause() const noexcept { return cause_; }

 private:
  Cause cause_;
};

}  // namespace tessera
