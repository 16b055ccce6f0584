// What happens to jobs, told to whoever listens, in order: by one thread, while no lock is held.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/service/staging_folder.h"

namespace tessera {

class Events {
 public:
  using Shared = std::shared_ptr<const proto::Event>;
  using OnEvent = std::function<void(const Shared&)>;

  static constexpr std::size_t kept_max = 2'000;  // some minutes of a few jobs, 3 MB

  // Numbers go on where those of earlier processes ended: `numbers` is the file in which they are set aside, many at
  // once, written over `desk`. What is wrong with that file is told to `log`, and numbers go on from the time of day,
  // which is beyond all that were given. Error io.
  static Result<std::unique_ptr<Events>> open(std::filesystem::path numbers, StagingFolder& desk,
                                              const std::function<void(const std::string&)>& log);
  ~Events();
  Events(const Events&) = delete;

  // Gives it the next number. Never waits for a listener.
  void tell(proto::Event event);

  // Events after `last`; 0: from now on. Those of one job when `job` is not empty. When events after `last` are not
  // kept any more, `instead` makes what is told in their place: they get the number before the first that is kept. The
  // thread that tells calls on_event; when the handle's destructor returns it is not called any more.
  class Listener;
  std::shared_ptr<Listener> listen(std::string job, std::uint64_t last, OnEvent on_event,
                                   const std::function<std::vector<proto::Event>()>& instead);
  void leave(const std::shared_ptr<Listener>& listener);
  std::size_t listeners() const;

 private:
  Events(std::filesystem::path numbers, StagingFolder& desk) : numbers_(std::move(numbers)), desk_(desk) {}
  Status reserve(std::uint64_t from);
  void deliver();

  std::filesystem::path numbers_;
  StagingFolder& desk_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Shared> kept_;
  std::uint64_t next_ = 1, reserved_ = 0;  // numbers below `reserved_` may be given
  std::vector<std::shared_ptr<Listener>> listeners_;
  bool ending_ = false, new_listener_ = false;
  std::thread thread_;
};

}  // namespace tessera
