#include "src/front/api/far_objects.h"

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <utility>

#include "src/input/remote/remote_objects.h"

namespace tessera {
namespace {

// With more, programs that count up a profile's name would keep them all.
constexpr std::size_t different_options_max = 16;

// What remote_objects() goes by: a change of it makes other objects.
std::string words_of(const remote::S3Options& options) {
  std::string words = options.endpoint + '\n' + options.profile + '\n' + (options.anonymous ? "a" : "") +
                      (options.requester_pays ? "p" : "");
  for (const char* name :
       {"AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_PROFILE", "AWS_REGION",
        "AWS_DEFAULT_REGION", "AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_SHARED_CREDENTIALS_FILE",
        "AWS_CONFIG_FILE", "HOME", "SSL_CERT_FILE", "CURL_CA_BUNDLE"}) {
    const char* value = std::getenv(name);
    words += '\n' + std::string(value == nullptr ? "" : value);
  }
  return words;
}

struct KnownObjects {
  std::mutex mutex;
  pid_t process = ::getpid();
  std::map<std::string, std::shared_ptr<Objects>> by_words;
};

// For functions that do not say how. The environment may change from call to call.
class ByEnvironment : public Objects {
 public:
  Result<std::shared_ptr<const ByteSource>> open(const std::string& name, std::stop_token stop) override {
    return far_objects({})->open(name, std::move(stop));
  }
  Result<std::vector<std::string>> names(const std::string& name, bool recursive, std::stop_token stop) override {
    return far_objects({})->names(name, recursive, std::move(stop));
  }
  Status copy(const std::string& name, ObjectTaker& to, std::stop_token stop) override {
    return far_objects({})->copy(name, to, std::move(stop));
  }
  Result<bool> exists(const std::string& name, std::stop_token stop) override {
    return far_objects({})->exists(name, std::move(stop));
  }
  Status put(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
             std::stop_token stop) override {
    return far_objects({})->put(objects, told, std::move(stop));
  }
  Status check_writable(const std::string& name, std::stop_token stop) override {
    return far_objects({})->check_writable(name, std::move(stop));
  }
  Status remove(const std::string& name, std::stop_token stop) override {
    return far_objects({})->remove(name, std::move(stop));
  }
};

}  // namespace

std::shared_ptr<Objects> far_objects(const remote::S3Options& options) {
  static KnownObjects known;
  const std::lock_guard lock(known.mutex);
  const pid_t process = ::getpid();
  if (known.process != process || known.by_words.size() >= different_options_max) known.by_words.clear();
  known.process = process;
  auto& objects = known.by_words[words_of(options)];
  if (!objects)
    objects = remote::remote_objects(
        {.s3 = options, .ca_file = remote::ca_file_of([](const char* name) { return std::getenv(name); })});
  return objects;
}

void set_far_objects() {
  static const bool set = [] {
    set_objects(std::make_shared<ByEnvironment>());
    return true;
  }();
  static_cast<void>(set);
}

}  // namespace tessera
