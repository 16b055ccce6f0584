// The exception that all functions of the public library throw.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tessera/visibility.h"

namespace tessera {

// The kind of a failure. The numbers are the exit statuses of docs/exit-status.md.
enum class Cause : std::uint8_t {
  usage = 2,         // an argument makes no sense
  bad_input = 3,     // the points or files cannot be triangulated
  io = 4,            // the operating system refused
  corrupt = 5,       // a result is damaged
  not_delaunay = 6,  // verify() found that a result is wrong
  memory = 7,        // the work does not fit into the memory that is allowed
  interrupted = 8,   // a stop was requested
  internal = 9,      // a bug of Tessera
};

// Returns the name of an option, for messages. `value` is a value of the option ("true" or "false" for a switch), or
// empty when the message names the option alone.
using OptionName = std::function<std::string(std::string_view key, std::string_view value)>;

// Every failure of the library. what() is one sentence that names the file or argument, the place, and the reason.
class TESSERA_PUBLIC Failure : public std::runtime_error {
 public:
  Failure(Cause cause, const std::string& sentence);
  Failure(const Failure&) = default;
  Failure& operator=(const Failure&) = default;
  ~Failure() override;  // defined in the library, so that the type is the same in program and library
  Cause cause() const noexcept { return cause_; }
  // Returns what() with the names that `name` gives to the options in it, for programs that have names of their own.
  // `name` gets the keys of the command: ("memory", "") where what() says memory_bytes, ("dim", "2") for dimension(2),
  // ("z", "false") for heights(false).
  std::string sentence(const OptionName& name) const;

 private:
  Cause cause_;
  std::shared_ptr<const std::string> marked_;  // shared, because copying an exception must not throw
};

}  // namespace tessera
