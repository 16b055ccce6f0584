// Exactness rests on what doubles do by default. Other code in a process may have changed that for its threads:
// libraries built with -ffast-math flush the smallest numbers to zero as soon as they are loaded (FTZ and DAZ), others
// round another way or trap. Threads begin with what the thread has that starts them.
#pragma once

#include <cfenv>

namespace tessera {

// While there is one, its thread has the arithmetic a program starts with; then that of before.
class DefaultArithmetic {
 public:
  DefaultArithmetic() {
    std::fegetenv(&before_);
    set();
  }
  DefaultArithmetic(const DefaultArithmetic&) = delete;
  DefaultArithmetic& operator=(const DefaultArithmetic&) = delete;
  ~DefaultArithmetic() { std::fesetenv(&before_); }

  // Again, after code of others has run.
  static void set() { std::fesetenv(FE_DFL_ENV); }

 private:
  std::fenv_t before_;
};

}  // namespace tessera
