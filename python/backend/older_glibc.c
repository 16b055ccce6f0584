/* What some libraries of Debian 12 use, and glibc 2.34 and the libstdc++ of GCC 11 lack: see older_glibc.py. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/random.h>
#include <sys/types.h>

/* glibc has it since 2.36. Expat fills the seed of its hash table with it. */
void arc4random_buf(void* bytes, size_t count) {
  unsigned char* to = bytes;
  while (count > 0) {
    const ssize_t got = getrandom(to, count < 256 ? count : 256, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) abort(); /* as glibc does without randomness */
    to += got;
    count -= (size_t)got;
  }
}

/* std::__glibcxx_assert_fail of GCC 12: a broken assertion of the standard library. */
void _ZSt21__glibcxx_assert_failPKciS0_S0_(const char* file, int line, const char* function, const char* condition) {
  if (file != NULL && function != NULL && condition != NULL)
    fprintf(stderr, "%s:%d: %s: Assertion '%s' failed.\n", file, line, function, condition);
  abort();
}
