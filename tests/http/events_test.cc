#include "src/service/http/events.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "src/service/live/version_events.h"

namespace tessera::service::http {
namespace {

std::shared_ptr<const proto::Event> event(std::uint64_t id, const std::string& state) {
  auto made = std::make_shared<proto::Event>();
  made->set_id(id);
  made->set_kind("status");
  made->set_job_id("j1");
  made->mutable_status()->set_status(state);
  return made;
}

TEST(EventText, IsOneEventOfTheStandard) {
  proto::Event told = *event(7, "running");
  told.set_text("two\nlines");
  const std::string text = event_text(told);
  EXPECT_EQ(text.find("id: 7\nevent: status\ndata: {"), 0U);
  EXPECT_EQ(text.find("\n\n"), text.size() - 2);
}

TEST(EventQueue, EndsWithTheJob) {
  EventTexts texts;
  EventQueue queue(texts, "j1", {});
  int woken = 0;
  queue.on_wake([&] { ++woken; });
  bool over = false;
  EXPECT_EQ(queue.take(over), "");
  queue.add(event(1, "running"));
  queue.add(event(2, "running"));
  EXPECT_EQ(woken, 1);
  EXPECT_NE(queue.take(over).find("id: 2"), std::string::npos);
  EXPECT_FALSE(over);
  queue.add(event(3, "successful"));
  queue.add(event(4, "running"));
  EXPECT_EQ(queue.take(over).find("id: 4"), std::string::npos);
  EXPECT_TRUE(over);
}

TEST(EventQueue, DropsAWatcherThatIsTooSlow) {
  EventTexts texts;
  EventQueue queue(texts, "", {.bytes = 1000});
  for (std::uint64_t id = 1; id < 100; ++id) queue.add(event(id, "running"));
  bool over = false;
  EXPECT_EQ(queue.take(over), "");
  EXPECT_TRUE(over);
}

// Otherwise the watcher would be dropped again and again, and never get on.
TEST(EventQueue, TakesAllVersionsThatAWatcherHasMissed) {
  const auto versions = std::make_shared<VersionEvents>(0);
  constexpr std::uint64_t all = 2000;
  for (std::uint64_t id = 1; id <= all; ++id) {
    proto::VersionMade made;
    made.set_version(id);
    for (int k = 0; k < (id % 50 == 0 ? 1000 : 4); ++k) {
      auto& box = *made.add_changed();
      for (int i = 0; i < 6; ++i) box.add_bounds(-1234567.123456789 + i);
    }
    versions->tell(made);
  }
  for (const std::uint64_t last : {std::uint64_t{0}, all / 2, all - 60, all - 1}) {
    EventTexts texts;
    EventQueue queue(texts, "", {});
    queue.keep(versions->follow(last, [&](const std::shared_ptr<const proto::Event>& event) { queue.add(event); }));
    bool over = false;
    const std::string text = queue.take(over);
    EXPECT_FALSE(over) << "after " << last;
    EXPECT_NE(text.find("id: " + std::to_string(all)), std::string::npos);
  }
}

TEST(EventTexts, AreThoseOfTheirEvents) {
  EventTexts texts;
  for (std::uint64_t id = 1; id < 200; ++id) {
    const auto one = event(id, "running"), other = event(id, "failed");
    EXPECT_EQ(*texts.of(one), event_text(*one));
    EXPECT_EQ(*texts.of(other), event_text(*other));
    EXPECT_EQ(texts.of(other), texts.of(other));
  }
}

}  // namespace
}  // namespace tessera::service::http
