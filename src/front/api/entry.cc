#include "src/front/api/entry.h"

#include <pthread.h>

#include <atomic>
#include <new>

#include "src/front/api/far_objects.h"
#include "tessera/failure.h"

namespace tessera {
namespace {

std::atomic<int> entries{0};
std::atomic<bool> forked_within{false};

const int not_registered = ::pthread_atfork(nullptr, nullptr, [] {
  if (entries > 0) forked_within = true;
});

}  // namespace

bool is_forked_within() { return forked_within; }

void refuse_if_forked_within() {
  if (!is_forked_within()) return;
  throw Failure(
      Cause::usage,
      "this process was forked while its parent was in a call of this library, which therefore cannot be used "
      "in it; fork before or after such calls, or start processes anew ('spawn' or 'forkserver' in Python)");
}

Entry::Entry() {
  if (not_registered != 0) throw std::bad_alloc();
  refuse_if_forked_within();
  set_far_objects();
  ++entries;
}

Entry::~Entry() { --entries; }

}  // namespace tessera
