// However often and whenever a service is killed, every job that it accepted ends once, as it would have ended alone.
// TESSERA_KILLS: how often; TESSERA_SEED: when.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "tests/service/service_testing.h"

extern char** environ;

namespace tessera::service::testing {
namespace {

namespace fs = std::filesystem;

int number_from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoi(text);
}

class Kill : public ServiceTest {
 protected:
  // The status of the driver, which is killed after a time unless that is negative.
  int drive(const fs::path& where, std::chrono::microseconds kill_after) {
    const std::string program = SERVICE_DRIVER, data = where.string(), roots = inputs().string();
    const fs::path output = folder.path() / "output";
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    std::vector<char*> arguments;
    for (const auto* argument : {&program, &data, &roots}) arguments.push_back(const_cast<char*>(argument->c_str()));
    arguments.push_back(nullptr);
    pid_t process = 0;
    EXPECT_EQ(::posix_spawn(&process, program.c_str(), &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    if (kill_after.count() >= 0) {
      std::this_thread::sleep_for(kill_after);  // the moment is the point
      ::kill(process, SIGKILL);
    }
    int status = 0;
    ::waitpid(process, &status, 0);
    std::ifstream lines(output);
    for (std::string key, id; lines >> key >> id;) {
      // The last line may be cut short.
      if (!lines.eof()) accepted[key].insert(id);
    }
    return status;
  }

  // What the data folder holds in the end, by key: state and digest.
  std::map<std::string, std::string> outcome(const fs::path& where) {
    options.data = where;
    service.reset();
    open();
    std::map<std::string, std::string> found;
    JobQuery query{.limit = 1000};
    const auto jobs = service->jobs().list(query).value();
    EXPECT_EQ(jobs.number_matched(), accepted.size());
    std::map<std::string, std::string> states;
    for (const auto& job : jobs.jobs())
      states[job.id()] = job.status() + (job.has_problem() ? job.problem().detail() : "");
    for (const auto& [key, ids] : accepted) {
      EXPECT_EQ(ids.size(), 1) << key;
      found[key] = states[*ids.begin()];
    }
    const auto triangulations = service->results().list(100, "").value();
    for (const auto& result : triangulations.triangulations()) found["/" + result.name()] = result.digest();
    service.reset();
    for (const auto& entry : fs::recursive_directory_iterator(where)) {
      const auto path = entry.path().lexically_relative(where).string();
      if (path.starts_with("results/")) found[path] = "there";
      EXPECT_EQ(path.find(".tmp"), std::string::npos) << path;
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(where / "jobs"), fs::directory_iterator()),
              static_cast<std::ptrdiff_t>(accepted.size()));
    return found;
  }

  std::map<std::string, std::set<std::string>> accepted;  // by key
};

TEST_F(Kill, EveryAcceptedJobEndsOnceWithTheSameResultAndNothingIsLeft) {
  make_cloud("a.ply", 30'000);
  make_cloud("b.ply", 20'000, 2);
  std::ofstream(inputs() / "bad.xyz") << "1 2 3\n4 5 6\n7 8 9\n1 2 nan\n";
  const auto began = std::chrono::steady_clock::now();
  ASSERT_EQ(drive(folder.path() / "whole", std::chrono::microseconds(-1)), 0);
  const auto took = std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - began);
  const auto expected = outcome(folder.path() / "whole");
  ASSERT_EQ(accepted.size(), 17);
  EXPECT_EQ(expected.at("o"), "successful");
  EXPECT_EQ(expected.at("/t1"), expected.at("/t2"));

  accepted.clear();
  const auto data = folder.path() / "killed";
  std::mt19937_64 random(static_cast<std::uint64_t>(number_from_environment("TESSERA_SEED", 1)));
  const int kills = number_from_environment("TESSERA_KILLS", 20);
  int killed = 0, rounds = 0;
  while (killed < kills) {
    // In a third of the time of a whole run; a run that gets to its end begins another folder.
    const auto after = std::uniform_int_distribution<std::int64_t>(0, took.count() / 3)(random);
    const int status = drive(data, std::chrono::microseconds(after));
    if (WIFSIGNALED(status)) {
      ++killed;
      continue;
    }
    ASSERT_EQ(status, 0);
    ASSERT_EQ(outcome(data), expected) << "after " << killed << " kills";
    fs::remove_all(data);
    accepted.clear();
    ++rounds;
  }
  ASSERT_EQ(drive(data, std::chrono::microseconds(-1)), 0);
  EXPECT_EQ(outcome(data), expected);
  std::printf("%d kills in %d queues\n", killed, rounds + 1);
}

}  // namespace
}  // namespace tessera::service::testing
