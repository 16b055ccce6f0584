// How everything in the public library fails: by one exception type.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tessera/visibility.h"

namespace tessera {

// The groups of docs/exit-status.md.
enum class Cause : std::uint8_t {
  usage = 2,         // an argument that makes no sense
  bad_input = 3,     // points or files that cannot be triangulated
  io = 4,            // the system refused
  corrupt = 5,       // a result that is damaged
  not_delaunay = 6,  // a result that verify() found wrong
  memory = 7,        // not within the memory given
  interrupted = 8,   // a stop was requested
  internal = 9,      // a mistake of ours
};

// What an option is called; `value` is empty when the option alone is meant, and "true" or "false" of a switch.
using OptionName = std::function<std::string(std::string_view key, std::string_view value)>;

// what() is one sentence: which file or argument, which place, what is wrong.
class TESSERA_PUBLIC Failure : public std::runtime_error {
 public:
  Failure(Cause cause, const std::string& sentence);
  Failure(const Failure&) = default;
  Failure& operator=(const Failure&) = default;
  ~Failure() override;  // not here, so that its type is one in program and library
  Cause cause() const noexcept { return cause_; }
  // what(), with other names for the options in it, for programs that call them otherwise. Their keys are those of the
  // command: ("memory", "") is what() calls memory_bytes, ("dim", "2") dimension(2), ("z", "false") heights(false).
  std::string sentence(const OptionName& name) const;

 private:
  Cause cause_;
  std::shared_ptr<const std::string> marked_;  // shared: an exception is copied without throwing
};

}  // namespace tessera
