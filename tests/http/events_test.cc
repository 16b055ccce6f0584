#include "src/service/http/events.h"

#include <gtest/gtest.h>

#include <string>

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
