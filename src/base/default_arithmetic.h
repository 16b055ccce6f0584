// The floating-point environment. Exactness needs the default behaviour of doubles. Other code in the process may have
// changed that for its threads: libraries built with -ffast-math flush the smallest numbers to zero (FTZ and DAZ) as
// soon as they are loaded, and other code changes rounding or traps. A new thread inherits the environment of the
// thread that starts it.
#pragma once

#include <cfenv>

namespace tessera {

// Gives its thread the default environment, and restores the old environment when destroyed.
class DefaultArithmetic {
 public:
  DefaultArithmetic() {
    std::fegetenv(&before_);
    set();
  }
  DefaultArithmetic(const DefaultArithmetic&) = delete;
  DefaultArithmetic& operator=(const DefaultArithmetic&) = delete;
  ~DefaultArithmetic() { std::fesetenv(&before_); }

  // Sets the default environment again, after foreign code has run.
  static void set() { std::fesetenv(FE_DFL_ENV); }

 private:
  std::fenv_t before_;
};

}  // namespace tessera
