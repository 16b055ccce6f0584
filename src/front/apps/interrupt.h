// Ctrl-C and `kill`: the first asks the job to stop, the second ends the process at once.
#pragma once

#include <memory>
#include <stop_token>

namespace tessera {

class Interrupt {
 public:
  Interrupt();  // from here SIGINT and SIGTERM are caught, on a thread of its own
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  std::stop_token token() const;

 private:
  struct Impl;  // keeps Asio out of the files that only want a token
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
