// Handles Ctrl-C and `kill`. The first signal requests a stop of the job, the second one ends the process at once.
#pragma once

#include <memory>
#include <stop_token>

namespace tessera::apps {

class Interrupt {
 public:
  Interrupt();  // from now on a thread of this object catches SIGINT and SIGTERM
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  std::stop_token token() const;

 private:
  struct Impl;  // keeps Asio out of the files that only need a token
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::apps
