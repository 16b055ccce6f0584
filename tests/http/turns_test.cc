#include "src/service/http/turns.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace tessera::service::http {
namespace {

// Work that is held until it is let go, and who is at work meanwhile.
class TurnsOfCallers : public testing::Test {
 protected:
  ~TurnsOfCallers() override {
    let_go();
    turns_->stop();
    turns_->join();
  }
  void post(const std::string& caller) {
    turns_->post(caller, [this, caller] {
      std::unique_lock lock(mutex_);
      order_.push_back(caller);
      ++running_[caller];
      changed_.notify_all();
      changed_.wait(lock, [&] { return free_ || one_ends_ == caller; });
      if (!free_) one_ends_.clear();
      --running_[caller];
      ++ended_;
      changed_.notify_all();
    });
  }
  void wait_for(const std::string& caller, int running) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return running_[caller] == running; });
  }
  void end_one(const std::string& caller) {
    std::unique_lock lock(mutex_);
    one_ends_ = caller;
    changed_.notify_all();
    changed_.wait(lock, [&] { return one_ends_.empty(); });
  }
  void let_go() {
    const std::scoped_lock lock(mutex_);
    free_ = true;
    changed_.notify_all();
  }
  void wait_for_end(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return ended_ == count; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, int> running_;
  std::vector<std::string> order_;
  std::size_t ended_ = 0;
  bool free_ = false;
  std::string one_ends_;
  std::shared_ptr<Turns> turns_ = std::make_shared<Turns>(
      TurnLimits{.usual = 2, .most = 3, .places = 6, .places_of_a_caller = 4, .bytes = 100, .bytes_of_a_caller = 60});
};

TEST_F(TurnsOfCallers, NobodyWaitsForTheWorkOfOthersAlone) {
  for (int at = 0; at < 4; ++at) post("ana");
  wait_for("ana", 2);
  post("bob");
  wait_for("bob", 1);  // beside the two
  post("bob");
  post("eve");
  end_one("ana");
  wait_for("eve", 1);  // who has nothing under way, before others that came earlier
  let_go();
  wait_for_end(7);
}

TEST_F(TurnsOfCallers, WhoHasHadNoTurnForLongestIsNext) {
  turns_ = std::make_shared<Turns>(TurnLimits{.usual = 1, .most = 1});
  post("ana");
  wait_for("ana", 1);
  for (int at = 0; at < 3; ++at) post("ana");
  for (int at = 0; at < 2; ++at) post("bob");
  post("eve");
  let_go();
  wait_for_end(7);
  EXPECT_EQ(order_, (std::vector<std::string>{"ana", "bob", "eve", "ana", "bob", "ana", "ana"}));
}

TEST_F(TurnsOfCallers, PlacesAreBoundedForACallerAndInAll) {
  std::deque<Turns::QueueSlot> held;
  const auto take = [&](const std::string& caller, std::uint64_t bytes) {
    auto place = turns_->enter(caller, bytes);
    if (!place) return false;
    held.push_back(std::move(*place));
    return true;
  };
  for (int at = 0; at < 4; ++at) EXPECT_TRUE(take("ana", 0));
  EXPECT_FALSE(take("ana", 0));
  EXPECT_TRUE(take("bob", 0));
  EXPECT_TRUE(take("eve", 0));
  EXPECT_FALSE(take("joe", 0)) << "six in all";
  held.clear();
  EXPECT_TRUE(take("ana", 60));
  EXPECT_FALSE(take("ana", 1)) << "of her bytes";
  EXPECT_TRUE(take("bob", 40));
  EXPECT_FALSE(take("eve", 1)) << "of all bytes";
  held.pop_front();
  EXPECT_TRUE(take("ana", 60));
}

TEST_F(TurnsOfCallers, WhatHasNotBegunIsForgottenAtTheEnd) {
  for (int at = 0; at < 5; ++at) post("ana");
  wait_for("ana", 2);
  auto place = turns_->enter("ana", 1);
  turns_->stop();
  let_go();
  turns_->join();
  EXPECT_EQ(ended_, 2U);
  turns_->post("ana", [] { FAIL(); });
  std::weak_ptr<Turns> left = turns_;
  turns_ = std::make_shared<Turns>(TurnLimits{});
  EXPECT_FALSE(left.expired()) << "places outlive it";
  place.reset();
  EXPECT_TRUE(left.expired());
}

}  // namespace
}  // namespace tessera::service::http
