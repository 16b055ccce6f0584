// Delivers what happens to jobs to all listeners, in order. One thread calls the listeners, and holds no lock then.
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

namespace tessera::service {

class Events {
 public:
  using Shared = std::shared_ptr<const proto::Event>;
  using OnEvent = std::function<void(const Shared&)>;

  static constexpr std::size_t kept_max = 2'000;  // some minutes of a few jobs; 3 MB

  // Numbers continue after those of earlier processes. The file `numbers` reserves many at a time; it is written over
  // `desk`. If the file is damaged, `log` gets a message, and numbers continue from the time of day in microseconds,
  // which is beyond all earlier numbers. Error io.
  static Result<std::unique_ptr<Events>> open(std::filesystem::path numbers, StagingFolder& desk,
                                              const std::function<void(const std::string&)>& log);
  ~Events();
  Events(const Events&) = delete;

  // Gives the event the next number and delivers it. Never waits for a listener.
  void tell(proto::Event event);

  // Delivers events after number `last`; 0: from now on. Only those of one job, unless `job` is empty. When some events
  // after `last` are no longer kept, `instead` makes events in their place, which get the number before the first kept
  // one. The delivering thread calls on_event. No call is made after the handle's destructor has returned.
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

}  // namespace tessera::service
