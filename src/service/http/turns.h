// Threads for work that may take long. Callers share the threads in turn, so that no caller's work waits only because
// of the work of others.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace tessera::service::http {

struct TurnLimits {
  std::uint32_t usual = 2;  // tasks of any callers at once
  std::uint32_t most = 8;   // more tasks, up to this number in all, only of callers with no task under way
  // Limits of requests that wait or are being answered, and of the bytes of their bodies.
  std::uint32_t places = 256, places_of_a_caller = 64;
  std::uint64_t bytes = std::uint64_t{64} << 20, bytes_of_a_caller = std::uint64_t{32} << 20;
};

// Thread-safe. Slots may outlive this object.
class Turns : public std::enable_shared_from_this<Turns> {
 public:
  // A request's slot in the queue. It is taken before the body is read, so that waiting bodies are bounded. The
  // destructor gives it back.
  class QueueSlot {
   public:
    QueueSlot(QueueSlot&&) noexcept = default;
    QueueSlot& operator=(QueueSlot&&) = delete;
    ~QueueSlot() {
      if (turns_) turns_->leave(caller_, bytes_);
    }

   private:
    friend Turns;
    QueueSlot(std::shared_ptr<Turns> turns, std::string caller, std::uint64_t bytes)
        : turns_(std::move(turns)), caller_(std::move(caller)), bytes_(bytes) {}
    std::shared_ptr<Turns> turns_;
    std::string caller_;
    std::uint64_t bytes_;
  };

  explicit Turns(const TurnLimits& limits) : limits_(limits) {}
  // REQUIRES: stop() and join() were called if anything was posted.
  ~Turns();

  // Returns nothing when there are too many requests already.
  std::optional<QueueSlot> enter(const std::string& caller, std::uint64_t bytes);
  // A thread calls `work()` when it is the caller's turn. After stop() no work is begun.
  template <class Work>
  void post(const std::string& caller, Work work) {
    add(caller, std::make_unique<TaskOf<Work>>(std::move(work)));
  }
  // Drops all work that has not begun.
  void stop();
  void join();

 private:
  struct Task {
    virtual ~Task() = default;
    virtual void run() = 0;
  };
  template <class Work>
  struct TaskOf final : Task {
    explicit TaskOf(Work given) : work(std::move(given)) {}
    void run() override { work(); }
    Work work;
  };
  struct Lane {  // of one caller
    std::deque<std::unique_ptr<Task>> waiting;
    std::uint32_t running = 0;
    std::uint64_t last_turn = 0;
    std::uint32_t places = 0;
    std::uint64_t bytes = 0;
    bool idle() const { return waiting.empty() && running == 0 && places == 0; }
  };
  using Lanes = std::map<std::string, Lane, std::less<>>;

  void add(const std::string& caller, std::unique_ptr<Task> task);
  void leave(const std::string& caller, std::uint64_t bytes);
  void work();
  // The caller whose turn it is; the end of `lanes_` when nothing may begin. REQUIRES: `mutex_` is held, here and
  // below.
  Lanes::iterator next();
  // Wakes or starts a thread for work that may begin.
  void wake();
  void forget_if_idle(Lanes::iterator lane);

  const TurnLimits limits_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Lanes lanes_;
  std::uint32_t running_ = 0, idle_threads_ = 0, places_ = 0;
  std::uint64_t bytes_ = 0, turn_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;  // started when needed
};

}  // namespace tessera::service::http
