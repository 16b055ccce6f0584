#include "src/service/http/turns.h"

#include <algorithm>

#include "src/base/check.h"
#include "src/base/thread_name.h"

namespace tessera::service::http {

Turns::~Turns() { check(threads_.empty(), "turns end with their threads joined"); }

std::optional<Turns::QueueSlot> Turns::enter(const std::string& caller, std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  if (places_ >= limits_.places || bytes_ + bytes > limits_.bytes) return std::nullopt;
  const auto lane = lanes_.try_emplace(caller).first;
  if (lane->second.places >= limits_.places_of_a_caller || lane->second.bytes + bytes > limits_.bytes_of_a_caller) {
    forget_if_idle(lane);
    return std::nullopt;
  }
  ++places_;
  ++lane->second.places;
  bytes_ += bytes;
  lane->second.bytes += bytes;
  return QueueSlot(shared_from_this(), caller, bytes);
}

void Turns::leave(const std::string& caller, std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  const auto lane = lanes_.find(caller);
  --places_;
  --lane->second.places;
  bytes_ -= bytes;
  lane->second.bytes -= bytes;
  forget_if_idle(lane);
}

void Turns::add(const std::string& caller, std::unique_ptr<Task> task) {
  const std::scoped_lock lock(mutex_);
  if (stopping_) return;
  lanes_[caller].waiting.push_back(std::move(task));
  wake();
}

void Turns::wake() {
  if (next() == lanes_.end()) return;
  if (idle_threads_ > 0 || threads_.size() >= limits_.most) return changed_.notify_one();
  threads_.emplace_back([this] {
    name_thread("turns");
    work();
  });
}

// The caller with the fewest tasks under way; of several, the one whose last turn is longest ago.
Turns::Lanes::iterator Turns::next() {
  auto found = lanes_.end();
  for (auto lane = lanes_.begin(); lane != lanes_.end(); ++lane) {
    const Lane& one = lane->second;
    if (one.waiting.empty()) continue;
    if (found == lanes_.end() ||
        std::pair(one.running, one.last_turn) < std::pair(found->second.running, found->second.last_turn))
      found = lane;
  }
  if (found == lanes_.end()) return found;
  const bool may = running_ < (found->second.running == 0 ? limits_.most : limits_.usual);
  return may ? found : lanes_.end();
}

void Turns::work() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const auto lane = next();
    if (lane == lanes_.end()) {
      ++idle_threads_;
      changed_.wait(lock);
      --idle_threads_;
      continue;
    }
    const std::string caller = lane->first;
    auto task = std::move(lane->second.waiting.front());
    lane->second.waiting.pop_front();
    ++lane->second.running;
    lane->second.last_turn = ++turn_;
    ++running_;
    wake();  // the thread that was woken for this work may have been woken for more
    lock.unlock();
    task->run();
    task.reset();
    lock.lock();
    const auto done = lanes_.find(caller);
    --done->second.running;
    --running_;
    forget_if_idle(done);
  }
}

void Turns::forget_if_idle(Lanes::iterator lane) {
  if (lane->second.idle()) lanes_.erase(lane);
}

void Turns::stop() {
  std::vector<std::unique_ptr<Task>> forgotten;  // destroyed without the lock: destructors may call leave()
  const std::scoped_lock lock(mutex_);
  stopping_ = true;
  for (auto& [caller, lane] : lanes_)
    for (auto& task : lane.waiting) forgotten.push_back(std::move(task));
  for (auto& [caller, lane] : lanes_) lane.waiting.clear();
  changed_.notify_all();
}

void Turns::join() {
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

}  // namespace tessera::service::http
