// A data folder, inputs and a service for tests.
#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/input/generate/generate.h"
#include "src/service/service.h"

namespace tessera::service::testing {

inline const Caller alice{"alice", Role::submit}, bob{"bob", Role::submit}, admin{"admin", Role::admin};

inline TemporaryFolder temporary_folder() {
  auto made = TemporaryFolder::make();
  if (!made) throw std::runtime_error(made.error().where);
  return std::move(made).value();
}

class ServiceTest : public ::testing::Test {
 protected:
  ServiceTest() {
    std::filesystem::create_directory(inputs());
    options.data = data();
    options.roots = {inputs()};
    options.memory_bytes = std::uint64_t{1} << 30;
    options.threads = 2;
  }

  std::filesystem::path data() const { return folder.path() / "data"; }
  std::filesystem::path inputs() const { return folder.path() / "inputs"; }

  // A cloud below the root.
  void make_cloud(const std::string& name, std::uint64_t points, std::uint64_t seed = 1, int dimension = 3) const {
    const auto made = generate({.points = points, .seed = seed, .dimension = dimension}, inputs() / name);
    ASSERT_TRUE(made) << made.error().where;
  }
  void open() {
    auto opened = Service::open(options);
    ASSERT_TRUE(opened) << opened.error().where;
    service = std::move(opened).value();
  }
  void restart() {
    service.reset();
    open();
  }

  static proto::Inputs triangulate(const std::string& input, const std::string& output = "") {
    proto::Inputs inputs;
    inputs.mutable_triangulate()->add_inputs(input);
    inputs.mutable_triangulate()->set_output(output);
    return inputs;
  }
  static proto::Inputs verify(const std::string& name) {
    proto::Inputs inputs;
    inputs.mutable_verify()->set_triangulation(name);
    return inputs;
  }
  std::string submit(const proto::Inputs& inputs, const Caller& caller = alice, const std::string& key = "") {
    const auto submitted = service->processes().submit(inputs, caller, key);
    if (!submitted) ADD_FAILURE() << submitted.error().detail();
    return submitted ? submitted.value().status.id() : "";
  }
  proto::Problem refused(const proto::Inputs& inputs, const Caller& caller = alice, const std::string& key = "") {
    const auto submitted = service->processes().submit(inputs, caller, key);
    if (!submitted) return submitted.error();
    ADD_FAILURE() << "accepted: " << inputs.ShortDebugString();
    return {};
  }
  proto::StatusInfo status(const std::string& id) {
    const auto status = service->jobs().status(id);
    if (!status) ADD_FAILURE() << status.error().detail();
    return status ? status.value() : proto::StatusInfo();
  }

  // Until the job is in a state for which `reached` is true, by its events.
  template <class Reached>
  proto::StatusInfo wait(const std::string& id, Reached reached) {
    std::mutex mutex;
    std::condition_variable changed;
    bool told = true;
    const auto handle = service->jobs().subscribe(id, 0, [&](const auto&) {
      const std::lock_guard lock(mutex);
      told = true;
      changed.notify_all();
    });
    while (true) {
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return told; });
        told = false;
      }
      const auto now = status(id);
      if (reached(now) || now.id().empty()) return now;
    }
  }
  proto::StatusInfo ended(const std::string& id) {
    return wait(id, [](const auto& now) { return now.status() != "accepted" && now.status() != "running"; });
  }
  proto::StatusInfo working(const std::string& id) {
    return wait(id, [](const auto& now) { return now.status() != "accepted"; });
  }

  const TemporaryFolder folder = temporary_folder();
  ServiceOptions options;
  std::unique_ptr<Service> service;
};

}  // namespace tessera::service::testing
