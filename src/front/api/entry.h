// Entry, which every call of the public library begins with. It sets the arithmetic of the thread, and refuses calls in
// processes that were forked at a bad moment.
#pragma once

#include "src/base/default_arithmetic.h"

namespace tessera {

// Every public function that works makes an Entry first, in the thread that called.
//
// A forked child has one thread and a copy of all memory. If no thread was in a call of the library, the copied library
// is at rest, and the child may use it. Otherwise locks may be held for ever, and the copied library may wait for
// threads that do not exist. So the child is refused, and so are its own children.
class Entry {
 public:
  Entry();  // throws Failure (usage) in a process that was forked while a thread had an Entry
  Entry(const Entry&) = delete;
  Entry& operator=(const Entry&) = delete;
  ~Entry();

 private:
  DefaultArithmetic arithmetic_;
};

// Returns whether this process was forked while a thread had an Entry. Then the objects of that call must be left
// alone: their threads do not exist here.
bool is_forked_within();
// Throws Failure (usage) if is_forked_within().
void refuse_if_forked_within();

// Calls a function of the program from within a call of the library. An empty function is not called. The function may
// fork and may change the arithmetic, so both are dealt with afterwards. Throws Failure (usage) in a forked child.
template <class Function, class... Arguments>
void call_back(const Function& function, const Arguments&... arguments) {
  if (!function) return;
  function(arguments...);
  DefaultArithmetic::set();
  refuse_if_forked_within();
}

}  // namespace tessera
