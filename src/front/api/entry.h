// What every call of the public library begins with.
#pragma once

#include "src/base/default_arithmetic.h"

namespace tessera {

// Made first in every public function that works, in the thread that called.
//
// A forked child has one thread and a copy of all memory. When nobody was in a call of the library, that is a library
// at rest, and the child may use it. Otherwise locks may be taken for ever and threads are awaited that are not there:
// the child, and what it forks, is refused.
class Entry {
 public:
  Entry();  // throws Failure (usage) in a process that was forked while some thread had an Entry
  Entry(const Entry&) = delete;
  Entry& operator=(const Entry&) = delete;
  ~Entry();

 private:
  DefaultArithmetic arithmetic_;
};

// Whether this process was forked while some thread had an Entry: what that work consists of can only be left alone.
bool is_forked_within();
// Throws Failure (usage) then.
void refuse_if_forked_within();

// Calls a program's function from within a call of the library, if there is one: it may fork, and change the
// arithmetic.
template <class Function, class... Arguments>
void call_back(const Function& function, const Arguments&... arguments) {
  if (!function) return;
  function(arguments...);
  DefaultArithmetic::set();
  refuse_if_forked_within();
}

}  // namespace tessera
