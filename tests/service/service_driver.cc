// A process that submits a queue of mixed jobs, each once however often it is started, and ends when all have ended.
//   service_driver DATA INPUTS
// Prints "KEY ID" for each job that was accepted, and ends with 1 when a submission is refused that must not be.
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "src/service/service.h"

namespace tessera::service {
namespace {

const Caller caller{"driver", Role::admin};

struct Driver {
  std::unique_ptr<Service> service;
  std::vector<std::string> submitted;

  bool submit(const std::string& key, const proto::Inputs& inputs) {
    const auto job = service->processes().submit(inputs, caller, key);
    if (!job) {
      std::fprintf(stderr, "%s: %s\n", key.c_str(), job.error().detail().c_str());
      return false;
    }
    std::printf("%s %s\n", key.c_str(), job.value().status.id().c_str());
    std::fflush(stdout);
    submitted.push_back(job.value().status.id());
    return true;
  }

  bool all_ended() {
    for (const auto& id : submitted) {
      const auto job = service->jobs().status(id);
      if (!job || job.value().status() == "accepted" || job.value().status() == "running") return false;
    }
    return true;
  }
  void wait() {
    std::mutex mutex;
    std::condition_variable changed;
    bool told = true;
    const auto handle = service->jobs().subscribe("", 0, [&](const auto&) {
      const std::lock_guard lock(mutex);
      told = true;
      changed.notify_all();
    });
    while (!all_ended()) {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return told; });
      told = false;
    }
  }
};

proto::Inputs triangulate(const std::string& input, const std::string& output, std::uint32_t tiles) {
  proto::Inputs inputs;
  inputs.mutable_triangulate()->add_inputs(input);
  inputs.mutable_triangulate()->set_output(output);
  inputs.mutable_triangulate()->set_tiles(tiles);
  return inputs;
}

int drive(const std::string& data, const std::string& roots) {
  ServiceOptions options;
  options.data = data;
  options.roots = {roots};
  options.memory_bytes = std::uint64_t{1} << 30;
  options.threads = 2;
  options.limits.running = 2;
  options.limits.deaths = 1'000'000;  // they are the test's, not the jobs'
  auto opened = Service::open(options);
  if (!opened) {
    std::fprintf(stderr, "%s\n", in_plain_words(opened.error().where).c_str());
    return 1;
  }
  Driver driver{std::move(opened).value(), {}};
  bool good = true;
  for (int i = 0; i < 4; ++i) {
    const auto n = std::to_string(i);
    good = good && driver.submit("t" + n, triangulate("a.ply", "t" + n, 1 + 3 * i));
    good = good && driver.submit("bad" + n, triangulate("bad.xyz", "bad" + n, 1));
  }
  driver.wait();
  for (int i = 0; i < 4 && good; ++i) {
    const auto n = std::to_string(i);
    proto::Inputs verify, exported;
    verify.mutable_verify()->set_triangulation("t" + n);
    exported.mutable_export_()->set_triangulation("t" + n);
    exported.mutable_export_()->set_output(i == 0 ? "mesh.vtu" : "mesh.ply");
    // What replaces t0 takes its exports away; its own were accepted before.
    good = driver.submit("v" + n, verify) && driver.submit("e" + n, exported);
  }
  driver.wait();
  auto replacing = triangulate("b.ply", "t0", 5);
  replacing.mutable_triangulate()->set_overwrite(true);
  good = good && driver.submit("o", replacing);
  driver.wait();
  return good ? 0 : 1;
}

}  // namespace
}  // namespace tessera::service

int main(int argc, char** argv) { return argc == 3 ? tessera::service::drive(argv[1], argv[2]) : 2; }
